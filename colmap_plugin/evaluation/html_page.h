#pragma once

#include <string>
#include <vector>

namespace structnerf {

struct HtmlPicture {
  std::string caption;
  std::string alternative;  // for those who cannot see it
  std::string data_uri;     // see map_pictures.h; empty = caption alone
};

// A colour scale and what its ends stand for.
struct HtmlScale {
  std::string name;
  std::string low;
  std::string high;
  std::string data_uri;
};

// One page that needs no other file. Texts may hold any character; they are
// shown as they are.
class HtmlPage {
 public:
  explicit HtmlPage(const std::string& title);

  void AddHeading(const std::string& text);
  void AddParagraph(const std::string& text);

  // The first row and the first column are headings.
  void AddTable(const std::vector<std::vector<std::string>>& rows);

  // Side by side as many as fit.
  void AddPictures(const std::vector<HtmlPicture>& pictures);

  // Rows of equally many, each under that above it.
  void AddPictureRows(const std::vector<std::vector<HtmlPicture>>& rows);

  // Stays in sight while one scrolls.
  void AddLegend(const std::vector<HtmlScale>& scales,
                 const std::vector<std::string>& remarks);

  // Something of one's own, e.g. <svg>, taken as it is.
  void AddMarkup(const std::string& markup) { body_ += markup; }

  std::string Finish() const;

 private:
  void AddPicture(const HtmlPicture& picture);

  std::string head_;
  std::string body_;
};

std::string EscapeHtml(const std::string& text);

}  // namespace structnerf
