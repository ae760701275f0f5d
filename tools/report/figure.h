// What    A line plot as inline SVG: axes with round numbers, a legend, gaps where values are NaN.
// In      Series of x and y; layers below them: dots, coloured spans of x.
// Out     svg(): one <svg> that takes its colours from the page's style sheet (light and dark).
// Units   whatever the labels say.
// Errors  none; a figure without finite values shows its axes alone.
// Cost    ~2 us a point. At most kPointsMax points a series are drawn: the lowest and the highest
//         of each bin, so that no spike is lost.
// Source  own; tick steps 1, 2, 5 x 10^n.
#pragma once

#include <string>
#include <vector>

namespace pirvs::tools {

struct Series {
  std::string label;  // empty: not in the legend
  std::string style;  // class of the style sheet: "s1" .. "s5", "x", "y", "z", "truth"
  std::vector<double> x;
  std::vector<double> y;
  bool dashed = false;
};

struct Dots {
  std::string label;
  std::string style;
  std::vector<double> x;
  std::vector<double> y;
  double radius_px = 1.2;
};

struct Span {
  std::string style;
  double from, to;
};

class Figure {
 public:
  std::string title;
  std::string x_label;
  std::string y_label;
  int width = 1100;
  int height = 230;
  bool equal_axes = false;  // one metre is as long on both
  bool stacked = false;     // series are drawn as areas on top of each other; x of the first
  bool shared_time = true;  // x is the run's time: the cursor moves in all such figures at once
  bool show_legend = true;
  bool from_zero = false;       // y starts at 0
  double x_min = 0, x_max = 0;  // equal: from the data
  double y_quantile = 1;        // below 1: the few values above are cut off
  std::vector<Series> series;
  std::vector<Dots> dots;
  std::vector<Span> spans;

  std::string svg() const;

 private:
  struct Frame;
  Frame layout() const;
  std::vector<Series> drawn() const;
  void axes(const Frame& frame, std::string& out) const;
  void legend(const Frame& frame, std::string& out) const;
};

}  // namespace pirvs::tools
