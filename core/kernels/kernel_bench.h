// One row of `make bench` per kernel: ours, the reference and OpenCV's counterpart, measured in
// turn in one run so that their ratios hold on a machine whose speed drifts.
//
//   void bench(benchmark::State& state) { compare(state, {.calls, .ours, .reference, .opencv}); }
//   BENCHMARK(bench)->Name("equalize_752x480")->Apply(bench::rounds);
//
// Columns: Time = ours; ours_ns, reference_ns, opencv_ns per call (median over rounds);
// ours/reference and ours/opencv: below one, ours is faster. nan: there is none to compare with.
#pragma once

#include <benchmark/benchmark.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "core/kernels/image.h"

namespace pirvs::bench {

struct Variants {
  int calls = 1;  // kernel calls that one run of each function makes
  std::function<void()> ours;
  std::function<void()> reference;  // may be empty
  std::function<void()> opencv;     // may be empty
};

// CPU time of this thread: what other processes take is not counted.
inline double cpu_time_ns() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e9 + static_cast<double>(t.tv_nsec);
}

inline double run_ns(const std::function<void()>& work, int repeats) {
  const double begin_ns = cpu_time_ns();
  for (int i = 0; i < repeats; ++i) work();
  return (cpu_time_ns() - begin_ns) / repeats;
}

inline double median(std::vector<double>& values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

// A fixed number of rounds: a median needs no more, and a slow reference does not take minutes.
inline void rounds(benchmark::internal::Benchmark* row) {
  row->UseManualTime()->Iterations(101)->Unit(benchmark::kNanosecond);
}

inline void compare(benchmark::State& state, const Variants& variants) {
  cv::setNumThreads(1);
  constexpr double kRound_ns = 200e3;  // long against the clock, short against a time slice
  const std::function<void()>* const work[] = {&variants.ours, &variants.reference,
                                               &variants.opencv};
  int repeats[3] = {};
  std::vector<double> ns[3];
  for (int k = 0; k < 3; ++k)
    if (*work[k]) {
      run_ns(*work[k], 1);  // warm caches
      repeats[k] = std::max(1, static_cast<int>(kRound_ns / run_ns(*work[k], 1)));
    }
  for (auto _ : state) {
    for (int k = 0; k < 3; ++k)
      if (*work[k]) ns[k].push_back(run_ns(*work[k], repeats[k]) / variants.calls);
    state.SetIterationTime(ns[0].back() * 1e-9);
  }
  const char* const names[] = {"ours_ns", "reference_ns", "opencv_ns"};
  const char* const ratios[] = {"", "ours/reference", "ours/opencv"};
  const double ours_ns = median(ns[0]);
  state.counters[names[0]] = ours_ns;
  for (int k = 1; k < 3; ++k) {
    const double other_ns = ns[k].empty() ? std::nan("") : median(ns[k]);
    state.counters[names[k]] = other_ns;
    state.counters[ratios[k]] = ours_ns / other_ns;
  }
}

// Grey, 752 x 480. A frame of the recordings below PIRVS_DATA (default ../shared/data) if there is
// one, else texture of several scales. image 0 and 1 are two moments of the same camera.
inline cv::Mat image(int index) {
  const char* root = std::getenv("PIRVS_DATA");
  const std::filesystem::path folder =
      std::filesystem::path(root != nullptr ? root : "../shared/data") /
      "euroc_mh01_clip/mav0/cam0/data";
  std::error_code error;
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error))
    files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  if (files.size() > 101) {
    const cv::Mat read = cv::imread(files[100 + index], cv::IMREAD_GRAYSCALE);
    if (read.cols == 752 && read.rows == 480) return read;
  }
  cv::RNG random(5);
  cv::Mat sum(480, 752, CV_32F, cv::Scalar(0));
  for (int size = 6; size < 200; size *= 2) {
    cv::Mat noise(480 / size + 2, 752 / size + 2, CV_32F), large;
    random.fill(noise, cv::RNG::NORMAL, 0, 4.0 * std::sqrt(size));
    cv::resize(noise, large, sum.size(), 0, 0, cv::INTER_CUBIC);
    sum += large;
  }
  cv::Mat moved, grey;
  const cv::Mat shift = (cv::Mat_<double>(2, 3) << 1, 0, 1.7 * index, 0, 1, -0.8 * index);
  cv::warpAffine(sum, moved, shift, sum.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT_101);
  moved.convertTo(grey, CV_8U, 1, 110);
  return grey;
}

inline ImageView view(const cv::Mat& image) {
  return {image.data, image.cols, image.rows, static_cast<int>(image.step)};
}

// Evenly spread over the image, 40 px from its border, at many sub-pixel fractions.
inline std::vector<cv::Point2f> points(int count) {
  std::vector<cv::Point2f> out;
  for (int i = 0; i < count; ++i)
    out.emplace_back(40 + std::fmod(static_cast<float>(i) * 83.31f, 672.0f),
                     40 + std::fmod(static_cast<float>(i) * 37.77f, 400.0f));
  return out;
}

}  // namespace pirvs::bench
