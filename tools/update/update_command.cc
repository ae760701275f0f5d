// `pirvs update`: which version a device runs, or another one onto it.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <thread>

#include "tools/cli/command.h"
#include "tools/cli/progress.h"
#include "tools/dataset/input_error.h"
#include "tools/update/device_link.h"

namespace pirvs::tools {
namespace {

using Clock = std::chrono::steady_clock;

struct UpdateOptions {
  std::string host, bundle;
  double wait_s = 300;
};

// Of the line `version V slot a trial 2 boot ID`, or `... good boot ID`.
struct Running {
  std::string version, slot, boot;
  bool trial = false;
};

Running parse_running(const std::string& line) {
  Running out;
  std::istringstream words(line);
  for (std::string word; words >> word;) {
    if (word == "version") words >> out.version;
    if (word == "slot") words >> out.slot;
    if (word == "boot") words >> out.boot;
    if (word == "trial") out.trial = true;
  }
  if (out.boot.empty()) throw LinkError("the device answers in another language: " + line);
  return out;
}

Running ask(const std::string& host) {
  DeviceLink link(host);
  link.send("pirvs 1 version\n");
  std::string line;
  if (!link.read_line(line)) throw LinkError(host + ": the device closed the connection");
  return parse_running(line);
}

// What follows the word that the line begins with.
std::optional<std::string> after(const std::string& word, const std::string& line) {
  if (line.compare(0, word.size(), word) != 0) return std::nullopt;
  return line.size() > word.size() ? line.substr(word.size() + 1) : std::string();
}

// Follows what the device says, up to its verdict: why it refused the bundle, or nothing.
std::optional<std::string> follow(DeviceLink& link) {
  Progress bar("installing", 100);
  for (std::string line; link.read_line(line);) {
    if (const auto why = after("refused", line)) return why;
    if (after("installed", line)) return std::nullopt;
    if (const auto step = after("progress", line)) {
      size_t end = 0;
      const int percent = std::stoi("0" + *step, &end);
      bar.update(static_cast<size_t>(percent), step->substr(std::min(end, step->size())));
    }
  }
  throw LinkError("the device closed the connection before it said how the update went");
}

std::optional<std::string> transfer(const UpdateOptions& options) {
  const uint64_t bytes = std::filesystem::file_size(options.bundle);
  DeviceLink link(options.host);
  link.send("pirvs 1 update " + std::to_string(bytes) + "\n");
  std::string line;
  if (!link.read_line(line)) throw LinkError(options.host + ": closed the connection");
  if (const auto why = after("refused", line)) return why;
  {
    Progress bar("sending", bytes);
    link.send_file(options.bundle, bytes, [&](uint64_t done) { bar.update(done); });
  }
  return follow(link);
}

// The device starts again, and may do so up to three times more before it goes back.
Running wait_for_verdict(const UpdateOptions& options, const Running& before) {
  const auto end = Clock::now() + std::chrono::duration<double>(options.wait_s);
  std::string why = "it has not started again";
  std::string seen = before.boot;
  while (Clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::seconds(2));
    try {
      const Running now = ask(options.host);
      if (now.boot == before.boot) continue;
      if (!now.trial) return now;
      why = "version " + now.version + " is on trial still";
      if (now.boot != seen) std::printf("version %s started\n", now.version.c_str());
      seen = now.boot;
    } catch (const LinkError& error) {
      if (seen == before.boot) why = error.what();
    }
    std::fflush(stdout);
  }
  throw LinkError("gave up after " + std::to_string(static_cast<int>(options.wait_s)) +
                  " s: " + why);
}

int update(const UpdateOptions& options) {
  const Running before = ask(options.host);
  std::printf("version %s runs, slot %s%s\n", before.version.c_str(), before.slot.c_str(),
              before.trial ? ", on trial" : "");
  std::fflush(stdout);
  if (options.bundle.empty()) return kExitDone;
  if (const auto why = transfer(options)) {
    std::fprintf(stderr, "pirvs: update: the device refused it: %s\n", why->c_str());
    return kExitFailed;
  }
  std::printf("installed, the device starts again\n");
  std::fflush(stdout);
  const Running now = wait_for_verdict(options, before);
  if (now.slot == before.slot) {
    std::fprintf(stderr, "pirvs: update: the new version failed, version %s runs again\n",
                 now.version.c_str());
    return kExitFailed;
  }
  std::printf("version %s runs and is good, slot %s\n", now.version.c_str(), now.slot.c_str());
  return kExitDone;
}

int run_update(const UpdateOptions& options) {
  if (!options.bundle.empty() && !std::filesystem::is_regular_file(options.bundle)) {
    throw InputError("no such file", options.bundle, "`make BOARD=ironsides bundle` makes one");
  }
  try {
    return update(options);
  } catch (const LinkError& error) {
    std::fprintf(stderr, "pirvs: update: %s\n", error.what());
    return kExitFailed;
  }
}

std::function<int()> declare(CLI::App& app) {
  const auto options = std::make_shared<UpdateOptions>();
  app.add_option("host", options->host, "device, by name or address: pirvs.local, 192.168.7.1")
      ->required();
  app.add_option("bundle", options->bundle,
                 "update, made by `make bundle`; without one the version is printed");
  app.add_option("--wait", options->wait_s, "seconds until the new version must be good")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  return [options] { return run_update(*options); };
}

}  // namespace

const Command kUpdateCommand = {"update", "Put another version onto a device", declare};

}  // namespace pirvs::tools
