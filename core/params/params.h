// Parameters as data: one row per field of a plain struct of floats.
// In      A struct P and its rows; a name and a value to set.
// Out     The changed struct; a visit of every row with its present value, for docs and dumps.
// Errors  ParamStatus: kNotFound, kOutOfRange (NaN too), kNotWhole; nothing changes then.
// Cost    Linear in the rows; at start-up only.
// Source  STYLE principle 9. Beside the rows stand two asserts: every field has a row
//         (sizeof(P) == std::size(rows) * sizeof(float)) and in_range(P{}, rows).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace pirvs {

enum class ParamStatus : uint8_t {
  kOk,
  kNotFound,    // no row of that name
  kAmbiguous,   // several groups have a row of that name
  kNotANumber,  // the text is not a decimal number
  kOutOfRange,
  kNotWhole,  // the row is a count
};

constexpr const char* name(ParamStatus status) {
  switch (status) {
    case ParamStatus::kOk:
      return "ok";
    case ParamStatus::kNotFound:
      return "no such parameter";
    case ParamStatus::kAmbiguous:
      return "several groups have it";
    case ParamStatus::kNotANumber:
      return "not a number";
    case ParamStatus::kOutOfRange:
      return "out of range";
    case ParamStatus::kNotWhole:
      return "not a whole number";
  }
  return "unknown status";
}

// kUser: a robot builder can choose the value from what he knows of his machine. kExpert: the value
// follows from measurements of the estimator's accuracy; change it with those at hand.
enum class Audience : uint8_t { kUser, kExpert };

struct ParamUnit {
  const char* name;
  bool whole = false;  // a count: no fractions

  constexpr ParamUnit(const char* unit) : name(unit) {}  // implicit: {"m", ...} in a row
  constexpr ParamUnit(const char* unit, bool is_whole) : name(unit), whole(is_whole) {}
};

// The unit of a number of things.
constexpr ParamUnit count_of(const char* things) { return {things, true}; }

template <class P>
struct ParamRow {
  const char* name;
  float P::*field;
  float min;
  float max;
  ParamUnit unit;
  Audience audience;
  const char* meaning;

  constexpr ParamStatus check(float value) const {
    if (!(value >= min && value <= max)) return ParamStatus::kOutOfRange;
    // In range, so that the conversion is defined: no count reaches 2^31.
    const bool fits = !unit.whole || value == static_cast<float>(static_cast<int32_t>(value));
    return fits ? ParamStatus::kOk : ParamStatus::kNotWhole;
  }
};

template <class P, size_t N>
constexpr bool in_range(const P& params, const ParamRow<P> (&rows)[N]) {
  for (const ParamRow<P>& row : rows) {
    if (row.check(params.*row.field) != ParamStatus::kOk) return false;
  }
  return true;
}

template <class P, size_t N>
[[nodiscard]] ParamStatus set_param(P& params, const ParamRow<P> (&rows)[N], std::string_view name,
                                    float value) {
  for (const ParamRow<P>& row : rows) {
    if (name != row.name) continue;
    const ParamStatus status = row.check(value);
    if (status == ParamStatus::kOk) params.*row.field = value;
    return status;
  }
  return ParamStatus::kNotFound;
}

// Calls visit(row, value) for every row, in order.
template <class P, size_t N, class Visit>
void for_each_param(const P& params, const ParamRow<P> (&rows)[N], Visit&& visit) {
  for (const ParamRow<P>& row : rows) visit(row, params.*row.field);
}

}  // namespace pirvs
