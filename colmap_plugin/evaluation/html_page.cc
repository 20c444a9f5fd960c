#include "colmap_plugin/evaluation/html_page.h"

namespace structnerf {
namespace {

constexpr const char* kStyle = R"(<style>
:root { color-scheme: light dark; }
body { font: 15px/1.45 system-ui, sans-serif; margin: 1.5rem auto;
       max-width: 90rem; padding: 0 1rem; }
h2 { font-size: 1.05rem; margin: 2rem 0 .2rem; overflow-wrap: anywhere; }
table { border-collapse: collapse; }
th, td { border-bottom: 1px solid #8886; padding: .25rem .8rem .25rem 0;
         text-align: left; vertical-align: top; overflow-wrap: anywhere; }
td { font-variant-numeric: tabular-nums; }
.pictures { display: grid; gap: .6rem;
            grid-template-columns: repeat(auto-fill, minmax(15rem, 1fr)); }
figure { margin: 0; }
figcaption { font-size: .85rem; }
img, svg { display: block; max-width: 100%; height: auto; }
.pictures img { width: 100%; }
.legend { display: flex; flex-wrap: wrap; gap: .4rem 2rem; padding: .5rem 0;
          position: sticky; top: 0; background: Canvas; font-size: .85rem;
          border-bottom: 1px solid #8886; }
.scale { display: grid; grid-template-columns: auto 8rem auto; gap: .4rem;
         align-items: center; }
.scale img { width: 100%; height: .9rem; }
</style>
)";

}  // namespace

HtmlPage::HtmlPage(const std::string& title)
    : head_(
          "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n"
          "<meta charset=\"utf-8\">\n"
          "<meta name=\"viewport\" content=\"width=device-width, "
          "initial-scale=1\">\n<title>" +
          EscapeHtml(title) + "</title>\n" + kStyle + "</head>\n<body>\n<h1>" +
          EscapeHtml(title) + "</h1>\n") {}

void HtmlPage::AddHeading(const std::string& text) {
  body_ += "<h2>" + EscapeHtml(text) + "</h2>\n";
}

void HtmlPage::AddParagraph(const std::string& text) {
  body_ += "<p>" + EscapeHtml(text) + "</p>\n";
}

void HtmlPage::AddTable(const std::vector<std::vector<std::string>>& rows) {
  body_ += "<table>\n";
  for (size_t i = 0; i < rows.size(); ++i) {
    body_ += "<tr>";
    for (size_t j = 0; j < rows[i].size(); ++j) {
      const std::string tag = i == 0 || j == 0 ? "th" : "td";
      body_ += "<" + tag + ">" + EscapeHtml(rows[i][j]) + "</" + tag + ">";
    }
    body_ += "</tr>\n";
  }
  body_ += "</table>\n";
}

void HtmlPage::AddPictures(const std::vector<HtmlPicture>& pictures) {
  body_ += "<div class=\"pictures\">\n";
  for (const HtmlPicture& picture : pictures) {
    AddPicture(picture);
  }
  body_ += "</div>\n";
}

void HtmlPage::AddPictureRows(
    const std::vector<std::vector<HtmlPicture>>& rows) {
  body_ += "<div class=\"pictures\" style=\"grid-template-columns: repeat(" +
           std::to_string(rows.front().size()) + ", minmax(0, 1fr))\">\n";
  for (const std::vector<HtmlPicture>& row : rows) {
    for (const HtmlPicture& picture : row) {
      AddPicture(picture);
    }
  }
  body_ += "</div>\n";
}

void HtmlPage::AddLegend(const std::vector<HtmlScale>& scales,
                         const std::vector<std::string>& remarks) {
  body_ += "<div class=\"legend\">\n";
  for (const HtmlScale& scale : scales) {
    body_ += "<div class=\"scale\"><span>" +
             EscapeHtml(scale.name + " " + scale.low) +
             "</span><img alt=\"\" src=\"" + scale.data_uri + "\"><span>" +
             EscapeHtml(scale.high) + "</span></div>\n";
  }
  for (const std::string& remark : remarks) {
    body_ += "<div>" + EscapeHtml(remark) + "</div>\n";
  }
  body_ += "</div>\n";
}

void HtmlPage::AddPicture(const HtmlPicture& picture) {
  body_ += "<figure>";
  if (!picture.data_uri.empty()) {
    body_ += "<img loading=\"lazy\" alt=\"" + EscapeHtml(picture.alternative) +
             "\" src=\"" + picture.data_uri + "\">";
  }
  body_ +=
      "<figcaption>" + EscapeHtml(picture.caption) + "</figcaption></figure>\n";
}

std::string HtmlPage::Finish() const {
  return head_ + body_ + "</body>\n</html>\n";
}

std::string EscapeHtml(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

}  // namespace structnerf
