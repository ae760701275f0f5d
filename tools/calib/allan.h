// What    Noise densities of a sensor from a long rest: Allan deviation and the white noise and
//         random walk that explain it.
// In      Equally spaced values; their rate.
// Out     deviation over averaging time; densities per sqrt(Hz), and what the fit leaves.
// Units   those of the values; tau_s in s. White noise: unit/sqrt(Hz); walk: unit/s/sqrt(Hz).
// Errors  fit_noise: zero densities for fewer than 10 averaging times.
// Cost    ~20 ns a value and averaging time: 3 h at 200 Hz, six axes, in ~5 s.
// Source  overlapping Allan variance, IEEE Std 952-1997, annex C: N^2 / tau + K^2 tau / 3.
#pragma once

#include <vector>

namespace pirvs::tools {

struct AllanPoint {
  double tau_s = 0;
  double deviation = 0;
  double samples = 0;  // independent ones, about: length over tau
};

std::vector<AllanPoint> allan_deviation(const std::vector<double>& values, double rate_hz);

struct FittedNoise {
  double density = 0;
  double walk = 0;
  double floor = 0;  // the least deviation: the bias instability, about
};
FittedNoise fit_noise(const std::vector<AllanPoint>& points);
double modelled_deviation(const FittedNoise& noise, double tau_s);

}  // namespace pirvs::tools
