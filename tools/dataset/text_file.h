// A text file that is whole or fails. The folder it lies in is made.
// Errors  InputError: it cannot be opened, or finish() finds that the disk has refused something.
#pragma once

#include <cstdarg>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {

class TextFile {
 public:
  explicit TextFile(const std::string& path) : path_(path) {
    std::error_code error;  // opening tells
    std::filesystem::create_directories(std::filesystem::path(path).parent_path(), error);
    file_.reset(std::fopen(path.c_str(), "wb"));
    if (!file_) fail();
  }
  __attribute__((format(printf, 2, 3))) void print(const char* format, ...) {
    va_list args;
    va_start(args, format);
    std::vfprintf(file_.get(), format, args);
    va_end(args);
  }
  void put(const char* text) { std::fputs(text, file_.get()); }
  void finish() {
    if (std::fflush(file_.get()) != 0 || std::ferror(file_.get()) != 0) fail();
  }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  [[noreturn]] void fail() const {
    throw InputError("cannot write", path_, "check the folder, space and permissions");
  }

  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace pirvs::tools
