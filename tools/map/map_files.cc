#include "tools/map/map_files.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <memory>
#include <vector>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

struct Bytes {
  std::vector<char> all;
  size_t at = 0;
};

Status take(void* context, void* data, size_t size) {
  Bytes& from = *static_cast<Bytes*>(context);
  if (from.all.size() - from.at < size) return Status::kBadData;
  std::memcpy(data, from.all.data() + from.at, size);
  from.at += size;
  return Status::kOk;
}

Status give(void* context, const void* data, size_t size) {
  auto& to = static_cast<Bytes*>(context)->all;
  const char* const begin = static_cast<const char*>(data);
  to.insert(to.end(), begin, begin + size);
  return Status::kOk;
}

// The name of a file is in its folder, which is synced too.
bool sync(const std::string& path, int flags) {
  const int fd = ::open(path.c_str(), flags | O_CLOEXEC);
  if (fd < 0) return false;
  const bool done = ::fsync(fd) == 0;
  ::close(fd);
  return done;
}

}  // namespace

void read_map_file(const std::string& path, const std::function<Status(const MapSource&)>& load) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError("cannot open the map", path, "check the name");
  Bytes bytes{{std::istreambuf_iterator<char>(file), {}}};
  Status status = verify_map({&bytes, take});
  bytes.at = 0;
  if (status == Status::kOk) status = load({&bytes, take});
  if (status != Status::kOk) {
    throw InputError("not a map of this version, or damaged", path, "save it anew with --save-map");
  }
}

void write_map_file(const std::string& path, const Map& map) {
  Bytes bytes;
  const auto index = std::make_unique<MapIndex>();
  (void)save_map(map, {&bytes, give}, *index);
  const std::string part = path + ".part";
  std::ofstream file(part, std::ios::binary | std::ios::trunc);
  file.write(bytes.all.data(), static_cast<std::streamsize>(bytes.all.size()));
  file.close();
  const size_t slash = path.find_last_of('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  if (!file || !sync(part, O_WRONLY) || std::rename(part.c_str(), path.c_str()) != 0 ||
      !sync(folder, O_RDONLY)) {
    (void)std::remove(part.c_str());
    throw InputError("cannot write the map", path, "check space and permissions");
  }
}

}  // namespace pirvs::tools
