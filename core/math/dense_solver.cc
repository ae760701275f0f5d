#include "core/math/dense_solver.h"

namespace pirvs {
namespace {

void subtract_scaled(double* __restrict to, const double* __restrict row, double factor,
                     size_t count) {
  for (size_t j = 0; j < count; ++j) to[j] -= factor * row[j];
}

void solve_upper(const double* A, size_t stride, double* b, size_t n) {
  for (size_t i = n; i-- > 0;) {
    const double* row = A + i * stride;
    double sum = b[i];
    for (size_t j = i + 1; j < n; ++j) sum -= row[j] * b[j];
    b[i] = sum / row[i];
  }
}

}  // namespace

bool solve_spd(double* A, size_t stride, double* b, size_t n, double* marginal, size_t k) {
  for (size_t pivot = 0; pivot < n; ++pivot) {
    if (marginal != nullptr && pivot == n - k) {
      for (size_t i = 0; i < k; ++i) {
        for (size_t j = 0; j < k; ++j) {
          const size_t r = pivot + (i < j ? i : j), c = pivot + (i < j ? j : i);
          marginal[i * k + j] = A[r * stride + c];
        }
      }
    }
    const double* row = A + pivot * stride;
    if (!(row[pivot] > 0)) return false;
    const double inverse = 1.0 / row[pivot];
    for (size_t i = pivot + 1; i < n; ++i) {
      const double factor = row[i] * inverse;
      if (factor == 0) continue;
      subtract_scaled(A + i * stride + i, row + i, factor, n - i);
      b[i] -= factor * b[pivot];
    }
  }
  solve_upper(A, stride, b, n);
  return true;
}

void solve_factored(const double* A, size_t stride, double* b, size_t n) {
  for (size_t pivot = 0; pivot < n; ++pivot) {
    if (b[pivot] == 0) continue;
    const double* row = A + pivot * stride;
    subtract_scaled(b + pivot + 1, row + pivot + 1, b[pivot] / row[pivot], n - pivot - 1);
  }
  solve_upper(A, stride, b, n);
}

}  // namespace pirvs
