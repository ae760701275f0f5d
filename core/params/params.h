// Parameters as data: one row per field of a plain struct of floats.
// In      A struct P and its rows; a name and a value to set.
// Out     The changed struct; a visit of every row with its present value, for docs and dumps.
// Frames  none. Units are in the rows.
// Errors  set_param: kNotFound (no row of that name), kBadData (outside the row's range, or NaN);
//         nothing changes then.
// Cost    Linear in the rows; at start-up only.
// Source  STYLE principle 9. Beside the rows stand two asserts: every field has a row
//         (sizeof(P) == std::size(rows) * sizeof(float)) and in_range(P{}, rows).
#pragma once

#include <cstddef>
#include <string_view>

#include "core/base/status.h"

namespace pirvs {

template <class P>
struct ParamRow {
  const char* name;
  float P::*field;
  float min;
  float max;
  const char* unit;
  const char* meaning;

  constexpr bool accepts(float value) const { return value >= min && value <= max; }
};

template <class P, size_t N>
constexpr bool in_range(const P& params, const ParamRow<P> (&rows)[N]) {
  for (const ParamRow<P>& row : rows) {
    if (!row.accepts(params.*row.field)) return false;
  }
  return true;
}

template <class P, size_t N>
Status set_param(P& params, const ParamRow<P> (&rows)[N], std::string_view name, float value) {
  for (const ParamRow<P>& row : rows) {
    if (name != row.name) continue;
    if (!row.accepts(value)) return Status::kBadData;
    params.*row.field = value;
    return Status::kOk;
  }
  return Status::kNotFound;
}

// Calls visit(row, value) for every row, in order.
template <class P, size_t N, class Visit>
void for_each_param(const P& params, const ParamRow<P> (&rows)[N], Visit&& visit) {
  for (const ParamRow<P>& row : rows) visit(row, params.*row.field);
}

}  // namespace pirvs
