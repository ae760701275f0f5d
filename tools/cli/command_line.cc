#include "tools/cli/command_line.h"

#include <cmath>
#include <map>

namespace pirvs::tools {
namespace {

std::string quoted(const std::string& word) {
  const char* const plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=.,:/@%";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? "'\\''" : std::string(1, c);
  return out + "'";
}

}  // namespace

std::string command_line(const CLI::App& command) {
  std::string out = "pirvs " + command.get_name();
  std::map<const CLI::Option*, size_t> seen;  // an option that is repeated has one value each time
  for (const CLI::Option* option : command.parse_order()) {
    if (!option->get_positional()) out += " " + option->get_name();
    if (option->get_expected_max() == 0) continue;  // a flag
    out += " " + quoted(option->results().at(seen[option]++));
  }
  return out;
}

CLI::Validator not_negative() {
  const auto check = [](const std::string& text) {
    double value = -1;
    const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value >= 0;
    return good ? std::string() : "needs a number not below 0, not '" + text + "'";
  };
  return CLI::Validator(check, "NUMBER");
}

}  // namespace pirvs::tools
