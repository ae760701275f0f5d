#include "tools/calib/board_drawing.h"

#include <cstdarg>
#include <cstdio>
#include <fstream>

#include "tools/calib/tag_family.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

constexpr double kMargin_mm = 5, kFoot_mm = 16;  // the foot: text and ruler

void put(std::string& out, const char* format, ...) __attribute__((format(printf, 2, 3)));
void put(std::string& out, const char* format, ...) {
  char text[256];
  va_list args;
  va_start(args, format);
  std::vsnprintf(text, sizeof text, format, args);
  va_end(args);
  out += text;
}

// Text and squares of the page, in mm.
std::string page_content(const Target& target, double left_mm, double bottom_mm) {
  std::string out = "2.834645669 0 0 2.834645669 0 0 cm\n";  // mm
  for (const Square& square : black_squares(target)) {
    put(out, "%d g %.4f %.4f %.4f %.4f re f\n", square.black ? 0 : 1, left_mm + 1e3 * square.x_m,
        bottom_mm + 1e3 * square.y_m, 1e3 * square.side_m, 1e3 * square.side_m);
  }
  const double y_mm = bottom_mm - target.spacing * 1e3 * target.tag_m - 9;
  put(out, "0 g %.3f %.3f 100 0.5 re f\n", left_mm, y_mm);
  for (int i = 0; i <= 10; ++i) put(out, "%.3f %.3f 0.2 2 re f\n", left_mm + 10 * i, y_mm);
  put(out, "BT /F1 3 Tf %.3f %.3f Td (100 mm. Aprilgrid 36h11, %d x %d, tag %.2f mm, spacing %g:",
      left_mm, y_mm - 4, target.columns, target.rows, 1e3 * target.tag_m, target.spacing);
  put(out, " print at 100 %%, measure, correct tagSize in the yaml) Tj ET\n");
  return out;
}

}  // namespace

std::vector<Square> black_squares(const Target& target) {
  const Family family = make_family(2);
  const int bits = family->width_at_border;
  const double bit_m = target.tag_m / bits, gap_m = target.spacing * target.tag_m;
  std::vector<Square> out;
  for (int row = 0; row <= target.rows; ++row) {
    for (int column = 0; column <= target.columns; ++column) {
      out.push_back({column * target.pitch_m() - gap_m, row * target.pitch_m() - gap_m, gap_m});
    }
  }
  for (int tag = 0; tag < target.tags(); ++tag) {
    const Vec3 p = target.p_T(4 * tag);
    out.push_back({p.x(), p.y(), target.tag_m});
    for (int y = 0; y < bits; ++y) {
      for (int x = 0; x < bits; ++x) {
        if (!is_white(*family, tag, x, y)) continue;
        out.push_back({p.x() + x * bit_m, p.y() + (bits - 1 - y) * bit_m, bit_m, false});
      }
    }
  }
  return out;
}

void write_pdf(const Target& target, const Paper& paper, const std::string& path) {
  const double gap_mm = 1e3 * target.spacing * target.tag_m;
  const double pitch_mm = 1e3 * target.pitch_m();
  const double width_mm = target.columns * pitch_mm + gap_mm;
  const double height_mm = target.rows * pitch_mm + gap_mm;
  const double need_mm[2] = {width_mm + 2 * kMargin_mm, height_mm + 2 * kMargin_mm + kFoot_mm};
  const double page_mm[2] = {paper.width_mm > 0 ? paper.width_mm : need_mm[0],
                             paper.height_mm > 0 ? paper.height_mm : need_mm[1]};
  if (page_mm[0] < need_mm[0] - 1e-6 || page_mm[1] < need_mm[1] - 1e-6) {
    char text[96];
    std::snprintf(text, sizeof text, "it needs %.0f x %.0f mm", need_mm[0], need_mm[1]);
    throw InputError("the board does not fit the paper", text, "make --tag smaller");
  }
  const double left_mm = (page_mm[0] - width_mm) / 2 + gap_mm;
  const double bottom_mm = (page_mm[1] - kFoot_mm - height_mm) / 2 + kFoot_mm + gap_mm;
  const std::string content = page_content(target, left_mm, bottom_mm);
  std::string out = "%PDF-1.4\n";
  size_t at[5];
  const auto object = [&](int i, const std::string& body) {
    at[i - 1] = out.size();
    put(out, "%d 0 obj\n", i);
    out += body + "\nendobj\n";
  };
  std::string page;
  put(page, "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 %.3f %.3f] /Contents 4 0 R",
      page_mm[0] * 72 / 25.4, page_mm[1] * 72 / 25.4);
  object(1, "<< /Type /Catalog /Pages 2 0 R >>");
  object(2, "<< /Type /Pages /Kids [3 0 R] /Count 1 >>");
  object(3, page + " /Resources << /Font << /F1 5 0 R >> >> >>");
  object(4,
         "<< /Length " + std::to_string(content.size()) + " >>\nstream\n" + content + "endstream");
  object(5, "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>");
  const size_t table = out.size();
  put(out, "xref\n0 6\n0000000000 65535 f \n");
  for (const size_t offset : at) put(out, "%010zu 00000 n \n", offset);
  put(out, "trailer\n<< /Size 6 /Root 1 0 R >>\nstartxref\n%zu\n%%%%EOF\n", table);
  std::ofstream file(path, std::ios::binary);
  file << out;
  file.close();
  if (!file) throw InputError("cannot write", path, "check space and permissions");
}

}  // namespace pirvs::tools
