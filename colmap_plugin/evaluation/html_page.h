#pragma once

#include <string>
#include <vector>

namespace structnerf {

struct HtmlPicture {
  std::string caption;
  std::string alternative;  // for those who cannot see it
  std::string data_uri;     // see map_pictures.h
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

  // Something of one's own, e.g. <svg>, taken as it is.
  void AddMarkup(const std::string& markup) { body_ += markup; }

  std::string Finish() const;

 private:
  std::string head_;
  std::string body_;
};

std::string EscapeHtml(const std::string& text);

}  // namespace structnerf
