#include "colmap_plugin/evaluation/html_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

TEST(HtmlPageTest, ShowsTextsAsTheyAre) {
  HtmlPage page("A <title>");
  page.AddHeading("a & b");
  page.AddParagraph("1 < 2");
  page.AddTable({{"", "<A>"}, {"row", "\"x\""}});
  page.AddPictures(
      {{"caption", "<alternative>", "data:image/png;base64,AA=="}});
  page.AddLegend({{"Depth", "<1", ">2", "data:image/png;base64,BB=="}}, {"&"});
  page.AddPictureRows({{{"left", "", ""}, {"right", "r", "data:,C"}},
                       {{"below", "b", "data:,D"}, {"none: <", "", ""}}});
  const std::string html = page.Finish();
  EXPECT_THAT(html, StartsWith("<!DOCTYPE html>"));
  EXPECT_THAT(html, EndsWith("</body>\n</html>\n"));
  EXPECT_THAT(html, HasSubstr("<title>A &lt;title&gt;</title>"));
  EXPECT_THAT(html, HasSubstr("<h2>a &amp; b</h2>"));
  EXPECT_THAT(html, HasSubstr("<p>1 &lt; 2</p>"));
  EXPECT_THAT(html,
              HasSubstr("<tr><th></th><th>&lt;A&gt;</th></tr>\n"
                        "<tr><th>row</th><td>&quot;x&quot;</td></tr>"));
  EXPECT_THAT(html, HasSubstr("alt=\"&lt;alternative&gt;\""));
  EXPECT_THAT(html, HasSubstr("src=\"data:image/png;base64,AA==\""));
  EXPECT_THAT(html, HasSubstr("Depth &lt;1</span>"));
  EXPECT_THAT(html, HasSubstr("<div>&amp;</div>"));
  EXPECT_THAT(html, HasSubstr("repeat(2, "));
  EXPECT_THAT(html,
              HasSubstr("<figure><figcaption>left</figcaption></figure>\n"
                        "<figure><img loading=\"lazy\" alt=\"r\" "
                        "src=\"data:,C\"><figcaption>right"));
  EXPECT_THAT(html, HasSubstr("none: &lt;"));
}

TEST(HtmlPageTest, TakesMarkupAsItIs) {
  HtmlPage page("title");
  page.AddMarkup("<svg></svg>");
  EXPECT_THAT(page.Finish(), HasSubstr("<h1>title</h1>\n<svg></svg>"));
}

}  // namespace
}  // namespace structnerf
