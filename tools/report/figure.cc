#include "tools/report/figure.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <limits>

namespace pirvs::tools {
namespace {

constexpr size_t kPointsMax = 1600;

__attribute__((format(printf, 2, 3))) void add(std::string& out, const char* format, ...) {
  char text[512];
  va_list args;
  va_start(args, format);
  std::vsnprintf(text, sizeof text, format, args);
  va_end(args);
  out += text;
}

struct Range {
  double lo = std::numeric_limits<double>::infinity();
  double hi = -std::numeric_limits<double>::infinity();

  void take(double v) {
    if (!std::isfinite(v)) return;
    lo = std::min(lo, v);
    hi = std::max(hi, v);
  }
  bool empty() const { return !(lo <= hi); }
  double size() const { return hi - lo; }
};

double round_step(double range, int ticks) {
  const double raw = range / ticks;
  const double power = std::pow(10, std::floor(std::log10(raw)));
  const double digit = raw / power;
  return power * (digit <= 1 ? 1 : digit <= 2 ? 2 : digit <= 5 ? 5 : 10);
}

std::string tick_text(double value, double step) {
  const int digits = std::clamp(int(std::ceil(-std::log10(step) - 1e-9)), 0, 6);
  char text[32];
  std::snprintf(text, sizeof text, "%.*f", digits, std::abs(value) < step / 2 ? 0.0 : value);
  return text;
}

// The lowest and the highest point of each bin, in order of x.
Series thinned(const Series& in) {
  if (in.x.size() <= kPointsMax) return in;
  Series out = in;
  out.x.clear();
  out.y.clear();
  const size_t bins = kPointsMax / 2;
  for (size_t b = 0; b < bins; ++b) {
    const size_t begin = b * in.x.size() / bins;
    const size_t end = (b + 1) * in.x.size() / bins;
    size_t low = begin;
    size_t high = begin;
    for (size_t i = begin; i < end; ++i) {
      if (in.y[i] < in.y[low] || std::isnan(in.y[low])) low = i;
      if (in.y[i] > in.y[high] || std::isnan(in.y[high])) high = i;
    }
    for (const size_t i : {std::min(low, high), std::max(low, high)}) {
      out.x.push_back(in.x[i]);
      out.y.push_back(in.y[i]);
      if (low == high) break;
    }
  }
  return out;
}

// Each on top of the sum of those before; the largest sum of a bin stands for the bin.
std::vector<Series> stack_up(const std::vector<Series>& in) {
  std::vector<Series> out = in;
  if (in.empty()) return out;
  const size_t n = in[0].x.size();
  for (size_t s = 1; s < out.size(); ++s) {
    for (size_t i = 0; i < n; ++i) out[s].y[i] += out[s - 1].y[i];
  }
  if (n <= kPointsMax) return out;
  std::vector<Series> thin = out;
  for (Series& series : thin) {
    series.x.clear();
    series.y.clear();
  }
  for (size_t b = 0; b < kPointsMax; ++b) {
    const size_t begin = b * n / kPointsMax;
    const size_t end = (b + 1) * n / kPointsMax;
    const auto& top = out.back().y;
    const auto at = std::max_element(top.begin() + long(begin), top.begin() + long(end));
    const size_t i = size_t(at - top.begin());
    for (size_t s = 0; s < out.size(); ++s) {
      thin[s].x.push_back(out[s].x[i]);
      thin[s].y.push_back(out[s].y[i]);
    }
  }
  return thin;
}

}  // namespace

// The plot area in the drawing, and the data that it spans.
struct Figure::Frame {
  double left, top, right, bottom;
  Range x, y;

  double px(double v) const { return left + (v - x.lo) / x.size() * (right - left); }
  double py(double v) const {
    return std::clamp(bottom - (v - y.lo) / y.size() * (bottom - top), top - 40, bottom + 40);
  }
};

std::vector<Series> Figure::drawn() const {
  if (stacked) return stack_up(series);
  if (equal_axes) return series;
  std::vector<Series> out;
  for (const Series& s : series) out.push_back(thinned(s));
  return out;
}

Figure::Frame Figure::layout() const {
  Frame f{58, title.empty() ? 26.0 : 44.0, width - 14.0, height - 40.0, {}, {}};
  std::vector<double> values;
  for (const Series& s : drawn()) {
    for (const double v : s.x) f.x.take(v);
    for (const double v : s.y) {
      f.y.take(v);
      if (y_quantile < 1 && std::isfinite(v)) values.push_back(v);
    }
  }
  if (!values.empty()) {
    std::sort(values.begin(), values.end());
    f.y.hi = values[size_t(y_quantile * double(values.size() - 1))];
  }
  if (x_max > x_min) f.x = {x_min, x_max};
  if (from_zero || stacked) f.y.take(0);
  if (f.x.empty()) f.x = {0, 1};
  if (f.y.empty()) f.y = {0, 1};
  const double least = 1e-9 + 1e-6 * std::max(std::abs(f.y.lo), std::abs(f.y.hi));
  if (f.y.size() < least) f.y = {f.y.lo - 10 * least, f.y.hi + 10 * least};
  if (f.x.size() < 1e-9) f.x = {f.x.lo - 1, f.x.hi + 1};
  const double margin = 0.06 * f.y.size();
  if (!((from_zero || stacked) && f.y.lo == 0)) f.y.lo -= margin;
  f.y.hi += margin;
  if (!equal_axes) return f;
  f.x = {f.x.lo - 0.05 * f.x.size(), f.x.hi + 0.05 * f.x.size()};
  const double per_px = std::max(f.x.size() / (f.right - f.left), f.y.size() / (f.bottom - f.top));
  const auto widen = [](Range& range, double size) {
    const double middle = (range.lo + range.hi) / 2;
    range = {middle - size / 2, middle + size / 2};
  };
  widen(f.x, per_px * (f.right - f.left));
  widen(f.y, per_px * (f.bottom - f.top));
  return f;
}

void Figure::axes(const Frame& f, std::string& out) const {
  const double step_x = round_step(f.x.size(), std::max(3, int((f.right - f.left) / 90)));
  for (double v = std::ceil(f.x.lo / step_x) * step_x; v <= f.x.hi + 1e-9; v += step_x) {
    add(out, "<line class=grid x1=%.1f y1=%.1f x2=%.1f y2=%.1f />", f.px(v), f.top, f.px(v),
        f.bottom);
    add(out, "<text class=tick x=%.1f y=%.1f text-anchor=middle>%s</text>", f.px(v), f.bottom + 16,
        tick_text(v, step_x).c_str());
  }
  const double step_y = round_step(f.y.size(), std::max(4, int((f.bottom - f.top) / 34)));
  for (double v = std::ceil(f.y.lo / step_y) * step_y; v <= f.y.hi + 1e-9; v += step_y) {
    add(out, "<line class=grid x1=%.1f y1=%.1f x2=%.1f y2=%.1f />", f.left, f.py(v), f.right,
        f.py(v));
    add(out, "<text class=tick x=%.1f y=%.1f text-anchor=end>%s</text>", f.left - 7, f.py(v) + 4,
        tick_text(v, step_y).c_str());
  }
  add(out, "<text class=axis x=%.1f y=%.1f text-anchor=end>%s</text>", f.right, f.bottom + 33,
      x_label.c_str());
  add(out, "<text class=axis x=%.1f y=%.1f>%s</text>", f.left, f.top - 8, y_label.c_str());
  if (!title.empty()) add(out, "<text class=title x=%.1f y=16>%s</text>", f.left, title.c_str());
}

void Figure::legend(const Frame& f, std::string& out) const {
  struct Entry {
    std::string label, style;
    bool dashed, dot;
  };
  std::vector<Entry> entries;
  for (const Series& s : series) entries.push_back({s.label, s.style, s.dashed, false});
  for (const Dots& d : dots) entries.push_back({d.label, d.style, false, true});
  double x = f.right;
  for (auto e = entries.rbegin(); e != entries.rend(); ++e) {
    if (e->label.empty()) continue;
    x -= 6.6 * double(e->label.size());
    add(out, "<text class=legend x=%.1f y=%.1f>%s</text>", x, f.top - 8, e->label.c_str());
    x -= 20;
    if (e->dot) {
      add(out, "<circle class='dot %s' cx=%.1f cy=%.1f r=3.2 />", e->style.c_str(), x + 9,
          f.top - 12);
    } else if (stacked) {
      add(out, "<rect class='area %s' x=%.1f y=%.1f width=13 height=9 rx=2 />", e->style.c_str(),
          x + 2, f.top - 16);
    } else {
      add(out, "<line class='line %s%s' x1=%.1f y1=%.1f x2=%.1f y2=%.1f />", e->style.c_str(),
          e->dashed ? " dashed" : "", x, f.top - 12, x + 15, f.top - 12);
    }
    x -= 12;
  }
}

std::string Figure::svg() const {
  const Frame f = layout();
  std::string out;
  add(out, "<svg viewBox='0 0 %d %d' class='fig%s' data-l=%.1f data-r=%.1f data-t=%.1f ", width,
      height, shared_time ? " time" : "", f.left, f.right, f.top);
  add(out, "data-b=%.1f data-x0=%.9g data-x1=%.9g data-y0=%.9g data-y1=%.9g%s>", f.bottom, f.x.lo,
      f.x.hi, f.y.lo, f.y.hi, stacked ? " data-stacked=1" : "");
  static int clips = 0;
  const int clip = clips++;
  add(out, "<clipPath id=c%d><rect x=%.1f y=%.1f width=%.1f height=%.1f /></clipPath>", clip,
      f.left, f.top, f.right - f.left, f.bottom - f.top);
  for (const Span& s : spans) {
    add(out, "<rect class='span %s' x=%.1f y=%.1f width=%.1f height=%.1f />", s.style.c_str(),
        f.px(s.from), f.top, std::max(1.0, f.px(s.to) - f.px(s.from)), f.bottom - f.top);
  }
  axes(f, out);
  add(out, "<g clip-path='url(#c%d)'>", clip);
  for (const Dots& d : dots) {
    for (size_t i = 0; i < d.x.size(); ++i) {
      add(out, "<circle class='dot %s' cx=%.1f cy=%.1f r=%.1f />", d.style.c_str(), f.px(d.x[i]),
          f.py(d.y[i]), d.radius_px);
    }
  }
  const std::vector<Series> lines = drawn();
  for (size_t k = lines.size(); k-- > 0 && stacked;) {
    add(out, "<path class='area %s' data-label='%s' d='M%.1f %.1f", lines[k].style.c_str(),
        lines[k].label.c_str(), lines[k].x.empty() ? f.left : f.px(lines[k].x.front()), f.bottom);
    for (size_t i = 0; i < lines[k].x.size(); ++i) {
      add(out, "L%.1f %.1f", f.px(lines[k].x[i]), f.py(lines[k].y[i]));
    }
    add(out, "L%.1f %.1fZ'/>", lines[k].x.empty() ? f.left : f.px(lines[k].x.back()), f.bottom);
  }
  for (size_t k = 0; k < lines.size() && !stacked; ++k) {
    add(out, "<path class='line %s%s' data-label='%s' d='", lines[k].style.c_str(),
        lines[k].dashed ? " dashed" : "", lines[k].label.c_str());
    bool pen_down = false;
    for (size_t i = 0; i < lines[k].x.size(); ++i) {
      const bool finite = std::isfinite(lines[k].x[i]) && std::isfinite(lines[k].y[i]);
      if (finite) {
        add(out, "%c%.1f %.1f", pen_down ? 'L' : 'M', f.px(lines[k].x[i]), f.py(lines[k].y[i]));
      }
      pen_down = finite;
    }
    out += "'/>";
  }
  out += "</g>";
  if (show_legend) legend(f, out);
  out += "</svg>\n";
  return out;
}

}  // namespace pirvs::tools
