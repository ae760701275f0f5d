#include "tools/dataset/pairs.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bsp/api/imu.h"

namespace pirvs::tools {
namespace {

constexpr TimeNs kOneTrigger = 1'000'000;  // closer than this nothing is worth a word

std::string ms(TimeNs dt) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f ms", double(dt) * 1e-6);
  return text;
}

TimeNs median(std::vector<TimeNs> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

TimeNs distance(TimeNs a, TimeNs b) { return a < b ? b - a : a - b; }

// Both lists from their fronts on; what is taken is the front of one or of both.
class Pairing {
 public:
  Pairing(const std::vector<ListedImage>& left, const std::vector<ListedImage>& right,
          TimeNs right_later, TimeNs within)
      : left_(left), right_(right), right_later_(right_later), within_(within) {}

  bool next(PairedImages& out) {
    const bool any_left = i_ < left_.size(), any_right = j_ < right_.size();
    if (!any_left && !any_right) return false;
    const bool pair = any_left && any_right && belong_together();
    const bool use_left = pair || (any_left && (!any_right || left_[i_].t < right_at(j_)));
    out.t = use_left ? left_[i_].t : right_at(j_);
    if (pair) apart.push_back(right_at(j_) - left_[i_].t);
    if (use_left) out.file[0] = left_[i_++].file;
    if (pair || !use_left) out.file[1] = right_[j_++].file;
    return true;
  }

  std::vector<TimeNs> apart;  // of each pair, right less left

 private:
  const std::vector<ListedImage>& left_;
  const std::vector<ListedImage>& right_;
  TimeNs right_later_, within_;
  size_t i_ = 0, j_ = 0;

  TimeNs right_at(size_t j) const { return right_[j].t - right_later_; }
  bool belong_together() const {
    const TimeNs here = distance(left_[i_].t, right_at(j_));
    if (here > within_) return false;
    const bool right_has_nearer =
        j_ + 1 < right_.size() && distance(left_[i_].t, right_at(j_ + 1)) < here;
    const bool left_has_nearer =
        i_ + 1 < left_.size() && distance(left_[i_ + 1].t, right_at(j_)) < here;
    return !right_has_nearer && !left_has_nearer;
  }
};

// How far the nearest images are from each other where none is near enough.
TimeNs nearest(const std::vector<ListedImage>& left, const std::vector<ListedImage>& right,
               TimeNs right_later) {
  std::vector<TimeNs> all;
  size_t j = 0;
  for (const ListedImage& image : left) {
    const auto off = [&](size_t k) { return distance(image.t, right[k].t - right_later); };
    while (j + 1 < right.size() && off(j + 1) <= off(j)) ++j;
    all.push_back(off(j));
  }
  return median(all);
}

void note_pairs(const std::vector<TimeNs>& apart, InputLog& log) {
  const TimeNs middle = median(apart);
  std::vector<TimeNs> spread;
  for (const TimeNs dt : apart) spread.push_back(distance(dt, middle));
  const TimeNs scatter = median(spread);
  if (scatter > kOneTrigger) {
    log.note("the cameras' stamps are apart by " + ms(middle) + " and scatter by " + ms(scatter) +
             ": cameras that are not exposed together are worth less than one, try --mono");
  } else if (distance(middle, 0) > kOneTrigger) {
    log.note("the right camera is stamped " + ms(distance(middle, 0)) +
             (middle > 0 ? " after" : " before") + " the left one: taken as one exposure");
  }
}

template <class Row>
TimeNs interval_of(const std::vector<Row>& rows) {
  std::vector<TimeNs> steps;
  for (size_t i = 1; i < rows.size(); ++i) steps.push_back(rows[i].t - rows[i - 1].t);
  return median(steps);
}

}  // namespace

std::vector<PairedImages> pair_images(const std::vector<ListedImage>& left,
                                      const std::vector<ListedImage>& right, TimeNs right_later,
                                      InputLog& log) {
  const TimeNs within = std::max(kOneTrigger, interval_of(left) / 4);
  Pairing pairing(left, right, right_later, within);
  std::vector<PairedImages> out;
  for (PairedImages pair; pairing.next(pair); pair = {}) {
    if (pair.file[0].empty()) log.count("frames_without_left");
    if (pair.file[1].empty() && !right.empty()) log.count("frames_without_right");
    out.push_back(pair);
  }
  if (!left.empty() && !right.empty() && pairing.apart.empty()) {
    log.note("no image of the right camera is within " + ms(within) +
             " of one of the left, the nearest is " + ms(nearest(left, right, right_later)) +
             " away: each plays alone; give cam1's timeshift_cam_imu, or --mono");
  }
  note_pairs(pairing.apart, log);
  return out;
}

template <class Row>
TimeNs interval(const std::vector<Row>& rows) {
  return interval_of(rows);
}
template TimeNs interval(const std::vector<ListedImage>&);
template TimeNs interval(const std::vector<ImuSample>&);

template <class Row>
void note_gaps(const std::vector<Row>& rows, const std::string& what, TimeNs least, InputLog& log) {
  constexpr TimeNs kSteps = 3;
  const TimeNs gap = std::max(kSteps * interval_of(rows), least);
  size_t gaps = 0, longest = 0;
  for (size_t i = 1; i < rows.size(); ++i) {
    if (rows[i].t - rows[i - 1].t < gap) continue;
    ++gaps;
    const TimeNs length = rows[i].t - rows[i - 1].t;
    if (longest == 0 || length > rows[longest].t - rows[longest - 1].t) longest = i;
  }
  if (gaps == 0) return;
  log.count(what + "_gaps", gaps);
  char text[128];
  std::snprintf(text, sizeof text, "%s: %zu gap%s, the longest %.3f s, %.1f s after the first",
                what.c_str(), gaps, gaps > 1 ? "s" : "",
                to_seconds(rows[longest].t - rows[longest - 1].t),
                to_seconds(rows[longest - 1].t - rows[0].t));
  log.note(text);
}
template void note_gaps(const std::vector<ListedImage>&, const std::string&, TimeNs, InputLog&);
template void note_gaps(const std::vector<ImuSample>&, const std::string&, TimeNs, InputLog&);

}  // namespace pirvs::tools
