// What    Does a calibration still hold? From any flight, no board: points seen by both cameras and
//         again a moment later, against the gyro's turns.
// In      follow: a recording of a stereo camera and an IMU. judge: what it returned; samples; the
//         calibration in question.
// Out     How far what was taken for granted is off, with sigmas: time offset, the rig's turn
//         against the IMU, the right camera's turn against the left one, focal lengths.
// Frames  B, C0, C1. turn: true R_BC = Exp(turn) R_BC of the calibration; right turn likewise of
//         R_C0C1.
// Units   px, s, rad.
// Errors  InputError: one camera alone, hardly any points, samples of another time.
// Cost    ~25 ms a pair of frames, two looks in 0.15 s each; judging ~1 s.
// Source  Lucas, Kanade by OpenCV; Gauss-Newton, depths and translations eliminated; Huber weights.
#pragma once

#include <string>
#include <vector>

#include "tools/dataset/recording.h"

namespace pirvs::tools {

struct FlightPoint {
  Vec2 left, right, later;  // later: in the left camera
};

struct FlightLook {
  TimeNs t0 = 0, t1 = 0;  // stamps of the left camera
  std::vector<FlightPoint> points;
};

std::vector<FlightLook> follow(const Recording& recording);

struct FlightFinding {
  std::string what, unit;
  double value = 0, sigma = 0, limit = 0;

  bool told() const { return 3 * sigma < limit; }  // the flight says something about it
  bool bumped() const;
};

struct FlightVerdict {
  std::vector<FlightFinding> findings;
  size_t looks = 0, points = 0;
  double residual_px = 0;

  bool bumped() const;
};

FlightVerdict judge(const std::vector<FlightLook>& looks, const std::vector<ImuSample>& imu,
                    const Calibration& calibration);

}  // namespace pirvs::tools
