#include "tools/view/recorded_page.h"

#include <fstream>
#include <sstream>

#include "tools/view/page.h"

namespace pirvs::tools {

namespace {

std::string base64(const std::string& bytes) {
  constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve(bytes.size() / 3 * 4 + 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t three = 0;
    for (size_t k = 0; k < 3; ++k) {
      three = three << 8 | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0);
    }
    for (size_t k = 0; k < 4; ++k) {
      out += i + k > bytes.size() ? '=' : kLetters[three >> (18 - 6 * k) & 63];
    }
  }
  return out;
}

}  // namespace

std::string recorded_page(const std::vector<ViewMessage>& messages) {
  std::ostringstream text;
  text << std::ifstream(page_file(), std::ios::binary).rdbuf();
  std::string page = text.str();
  std::string recorded = "<script>window.pirvsRecorded=[";
  for (const ViewMessage& message : messages) {
    recorded += std::string("{binary:") + (message.binary ? "true" : "false") + ",base64:\"" +
                base64(*message.bytes) + "\"},\n";
  }
  recorded += "]</script>";
  constexpr char kPlace[] = "<!--recorded-->";
  const size_t at = page.find(kPlace);
  if (at != std::string::npos) page.replace(at, sizeof kPlace - 1, recorded);
  return page;
}

}  // namespace pirvs::tools
