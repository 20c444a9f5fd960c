#include "colmap_plugin/evaluation/comparison_report.h"
#include "colmap_plugin/evaluation/html_page.h"
#include "colmap_plugin/evaluation/map_pictures.h"
#include "colmap_plugin/text_output.h"

namespace structnerf {
namespace {

std::string Percent(const double share) {
  return FormatNumber("%.1f %%", 100 * share);
}

void AddNumbers(const Comparison& comparison, HtmlPage* page) {
  std::vector<std::vector<std::string>> rows = {{"", "A", "B"}};
  for (const ComparisonRow& row : ComparisonRows(comparison)) {
    rows.push_back({row.name, row.values[0], row.values[1]});
  }
  page->AddTable(rows);
  page->AddParagraph("Agreement: " + AgreementText(comparison.agreement) + ".");
  for (const std::string& note : comparison.notes) {
    page->AddParagraph("Note: " + note);
  }
}

// The same scales hold for all pictures.
void AddScales(const Comparison& comparison, HtmlPage* page) {
  const std::string unit = comparison.is_metric ? " m" : " units of A";
  const std::string error =
      FormatNumber("%g", 100 * comparison.largest_error) + " cm";
  const std::string error_bar = PngDataUri(ErrorScaleBar());
  std::vector<HtmlScale> scales = {
      {"Depth",
       FormatNumber("%.3g", comparison.nearest_depth) + unit,
       FormatNumber("%.3g", comparison.farthest_depth) + unit + " and more",
       PngDataUri(DepthScaleBar())},
      {"Difference",
       "0",
       FormatNumber("%g", 100 * comparison.largest_difference) + " % and more",
       error_bar}};
  if (comparison.is_metric) {
    scales.push_back({"Error", "0", error + " and more", error_bar});
    scales.push_back({"Smaller error: A by",
                      error,
                      "B by " + error,
                      PngDataUri(BalanceScaleBar())});
  }
  page->AddLegend(scales,
                  {"Normals: red right, green up, blue towards the camera",
                   "Grey: no value"});
}

void AddView(const ViewComparison& view, HtmlPage* page) {
  page->AddHeading(view.name);
  std::string text = "Coverage A " + Percent(view.coverage[0]) + ", B " +
                     Percent(view.coverage[1]) + "; " +
                     AgreementText(view.agreement);
  for (size_t i = 0; i < 2; ++i) {
    if (view.median_error[i]) {
      text += std::string("; median error ") + kLetters[i] + " " +
              FormatNumber("%.1f cm", 100 * *view.median_error[i]);
    }
  }
  page->AddParagraph(text + ".");
  page->AddPictureRows(view.pictures);
}

}  // namespace

std::string ComparisonHtml(const Comparison& comparison) {
  HtmlPage page("Comparison of two dense workspaces");
  AddNumbers(comparison, &page);
  AddScales(comparison, &page);
  size_t num_pictured = 0;
  for (const ViewComparison& view : comparison.views) {
    num_pictured += view.pictures.empty() ? 0 : 1;
  }
  if (num_pictured < comparison.views.size()) {
    page.AddParagraph(std::to_string(num_pictured) + " of " +
                      std::to_string(comparison.views.size()) +
                      " views are shown; the numbers above are of all.");
  }
  for (const ViewComparison& view : comparison.views) {
    if (!view.pictures.empty()) {
      AddView(view, &page);
    }
  }
  return page.Finish();
}

}  // namespace structnerf
