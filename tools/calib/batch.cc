#include "tools/calib/batch.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "tools/calib/result_files.h"
#include "tools/dataset/input_error.h"
#include "tools/report/page.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr Verdict kVerdicts[] = {Verdict::kPassed, Verdict::kFailed, Verdict::kRefused};

std::vector<std::string> recordings_in(const std::string& folder) {
  std::vector<std::string> out;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const fs::path& path = entry.path();
    if (fs::is_directory(path / "mav0") || fs::is_directory(path / "cam0")) {
      out.push_back(path.filename().string());
    }
  }
  if (out.empty()) {
    throw InputError("no recordings", folder, "give a folder with one ASL folder a device");
  }
  std::sort(out.begin(), out.end());
  return out;
}

// Exit status, or none after a signal or where the program cannot be started.
int run_logged(const std::vector<std::string>& words, const std::string& log) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                   0644);
  posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
  pid_t child = 0;
  const bool started = posix_spawn(&child, argv[0], &files, nullptr, argv.data(), environ) == 0;
  posix_spawn_file_actions_destroy(&files);
  int status = 0;
  if (!started || waitpid(child, &status, 0) != child || !WIFEXITED(status)) return -1;
  return WEXITSTATUS(status);
}

Json read_json(const std::string& path) {
  std::ifstream file(path);
  return file ? Json::parse(file, nullptr, false) : Json(Json::value_t::discarded);
}

std::string last_error(const std::string& log) {
  std::ifstream file(log);
  std::string out;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("pirvs: ", 0) == 0) out = line.substr(7);
  }
  return out.empty() ? "see " + log : out;
}

// The limits that were not kept.
std::string failed_checks(const std::string& folder) {
  const Json json = read_json(folder + "/calibration.json");
  std::string out;
  if (!json.is_object() || !json.contains("checks")) return "no calibration.json";
  for (const Json& check : json["checks"]) {
    if (check.value("passed", false)) continue;
    out += (out.empty() ? "" : "; ") + check.value("what", std::string());
  }
  return out;
}

bool read_outcome(const std::string& path, BatchRow& row) {
  const Json json = read_json(path);
  if (!json.is_object()) return false;
  for (const Verdict verdict : kVerdicts) {
    if (json.value("verdict", std::string()) != verdict_name(verdict)) continue;
    row.verdict = verdict;
    row.seconds = json.value("seconds", 0.0);
    row.reason = json.value("reason", std::string());
    row.kept = true;
    return true;
  }
  return false;  // a crash is tried again
}

BatchRow calibrate_one(const BatchOptions& o, const std::string& serial) {
  BatchRow row;
  row.serial = serial;
  const std::string out = o.out + "/" + serial, log = out + "/log.txt";
  if (!o.again && read_outcome(out + "/outcome.json", row)) return row;
  // What an earlier run left would be taken for this one's.
  std::error_code error;
  fs::remove_all(out, error);
  fs::create_directories(out, error);
  std::vector<std::string> words = {o.program,  "calib",  "device",   o.folder + "/" + serial,
                                    "--target", o.target, "--serial", serial,
                                    "--out",    out};
  words.insert(words.end(), o.more.begin(), o.more.end());
  const auto begin = std::chrono::steady_clock::now();
  const int status = run_logged(words, log);
  row.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (status == 0) {
    row.verdict = Verdict::kPassed;
  } else if (status == 1 && fs::exists(out + "/calibration.json")) {
    row.verdict = Verdict::kFailed;
    row.reason = failed_checks(out);
  } else {
    row.verdict = status == 2 ? Verdict::kRefused : Verdict::kCrashed;
    row.reason = last_error(log);
  }
  write_json(out + "/outcome.json", {{"serial", serial},
                                     {"verdict", verdict_name(row.verdict)},
                                     {"seconds", row.seconds},
                                     {"reason", row.reason}});
  return row;
}

std::string csv_word(std::string text) {
  std::replace(text.begin(), text.end(), '"', '\'');
  return '"' + text + '"';
}

void write_tables(const std::string& out, const std::vector<BatchRow>& rows) {
  std::ofstream csv(out + "/batch.csv"), html(out + "/batch.html");
  csv << "#serial,verdict,seconds,reason\n";
  std::string body;
  size_t passed = 0;
  for (const BatchRow& row : rows) {
    char seconds[32];
    std::snprintf(seconds, sizeof seconds, "%.1f", row.seconds);
    csv << csv_word(row.serial) << ',' << verdict_name(row.verdict) << ',' << seconds << ','
        << csv_word(row.reason) << '\n';
    const std::string name = html_escape(row.serial), folder = out + "/" + row.serial;
    const char* const page =
        fs::exists(folder + "/calibration.html") ? "/calibration.html" : "/log.txt";
    body += "<tr><td><a href=\"" + name + page + "\">" + name + "</a></td><td>" +
            verdict_name(row.verdict) + "</td><td>" + seconds + " s</td><td>" +
            html_escape(row.reason) + "</td></tr>\n";
    passed += row.verdict == Verdict::kPassed;
  }
  const std::string title =
      std::to_string(passed) + " of " + std::to_string(rows.size()) + " devices passed";
  html << html_page(title, "<header><div><h1>" + title +
                               "</h1></div></header>\n<div class=card><table>\n<tr><th>device</th>"
                               "<th>verdict</th><th>time</th><th>reason</th></tr>\n" +
                               body + "</table></div>\n");
  csv.close(), html.close();
  if (!csv || !html) throw InputError("cannot write", out, "check space and permissions");
}

}  // namespace

const char* verdict_name(Verdict verdict) {
  switch (verdict) {
    case Verdict::kPassed:
      return "passed";
    case Verdict::kFailed:
      return "failed";
    case Verdict::kRefused:
      return "refused";
    case Verdict::kCrashed:
      break;
  }
  return "crashed";
}

std::vector<BatchRow> run_batch(const BatchOptions& o,
                                const std::function<void(const BatchRow&)>& told) {
  const std::vector<std::string> serials = recordings_in(o.folder);
  std::error_code error;
  fs::create_directories(o.out, error);
  std::vector<BatchRow> rows(serials.size());
  std::atomic<size_t> next{0};
  std::mutex telling;
  std::exception_ptr failure;
  const auto work = [&] {
    for (size_t i = next++; i < serials.size(); i = next++) {
      try {
        rows[i] = calibrate_one(o, serials[i]);
        const std::lock_guard lock(telling);
        told(rows[i]);
      } catch (...) {  // the disk is full, say: what is true of one is true of the next
        const std::lock_guard lock(telling);
        failure = std::current_exception();
        next = serials.size();
      }
    }
  };
  const unsigned cores = std::max(2u, std::thread::hardware_concurrency());
  std::vector<std::thread> threads;
  for (unsigned k = 0; k < (o.jobs > 0 ? unsigned(o.jobs) : cores / 2); ++k) {
    threads.emplace_back(work);
  }
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
  write_tables(o.out, rows);
  return rows;
}

}  // namespace pirvs::tools
