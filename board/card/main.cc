// pirvs-card: the state of the slots, and the size of the last partition. See kHelp.
#include <errno.h>
#include <fcntl.h>
#include <linux/blkpg.h>
#include <linux/fs.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstring>

#include "board/card/partition_table.h"
#include "board/card/slot_state.h"
#include "core/base/text.h"

namespace pirvs::card {
namespace {

constexpr const char* kHelp =
    "pirvs-card: which slot of the card is started, and how large its last partition is.\n"
    "usage: pirvs-card get            good=a trial=b left=3 (copy 1)\n"
    "       pirvs-card try SLOT N     start SLOT next, N times at most (1 to 3)\n"
    "       pirvs-card good SLOT      SLOT is good, nothing is on trial\n"
    "       pirvs-card grow           the last partition takes what is free\n"
    "Before these: --card FILE, instead of /dev/pirvs-card.\n"
    "Exit status: 0 done, 1 the card cannot be read or written, 2 bad usage.\n";
constexpr int kExitFailed = 1, kExitBadUsage = 2;

// Direct input and output wants buffers of a page.
constexpr size_t kPage = 4096;
alignas(kPage) Sector sectors[2];
alignas(kPage) PartitionTable table;
alignas(kPage) Sector copy_of_header;
static_assert(sizeof(PartitionTable) == (1 + kEntrySectors) * kSectorBytes);

const char* card = "/dev/pirvs-card";
int fd = -1;

int usage() {
  (void)!write(STDERR_FILENO, kHelp, std::strlen(kHelp));
  return kExitBadUsage;
}

int fail(const char* what) {
  Text<256> line;
  line.put("pirvs-card: ").put(card).put(": ").put(what).put('\n');
  (void)!write(STDERR_FILENO, line.c_str(), line.size());
  return kExitFailed;
}

bool read_at(uint64_t sector, void* out, size_t bytes) {
  return pread(fd, out, bytes, static_cast<off_t>(sector * kSectorBytes)) ==
         static_cast<ssize_t>(bytes);
}

// On the card when it returns.
bool write_at(uint64_t sector, const void* from, size_t bytes) {
  return pwrite(fd, from, bytes, static_cast<off_t>(sector * kSectorBytes)) ==
             static_cast<ssize_t>(bytes) &&
         fdatasync(fd) == 0;
}

// ---- the slots ---------------------------------------------------------------------------------

bool read_sectors() {
  return read_at(kStateSectors[0], sectors[0], kSectorBytes) &&
         read_at(kStateSectors[1], sectors[1], kSectorBytes);
}

int get_state() {
  if (!read_sectors()) return fail(std::strerror(errno));
  SlotState state;
  const StateFrom from = read_state(sectors[0], sectors[1], state);
  Text<80> line;
  line.put("good=").put(state.good).put(" trial=");
  if (state.trial != 0) line.put(state.trial);
  line.put(" left=").number(state.left);
  line.put(from == StateFrom::kFirst    ? " (copy 1)\n"
           : from == StateFrom::kSecond ? " (copy 2)\n"
                                        : " (no copy)\n");
  return write(STDOUT_FILENO, line.c_str(), line.size()) < 0 ? kExitFailed : 0;
}

// Nothing is written where the card says so already.
int set_state(const SlotState& state) {
  Sector wanted;
  put_state(state, wanted);
  if (!read_sectors()) return fail(std::strerror(errno));
  for (int i = 0; i < 2; ++i) {
    if (std::memcmp(sectors[i], wanted, sizeof wanted) == 0) continue;
    std::memcpy(sectors[i], wanted, sizeof wanted);
    if (!write_at(kStateSectors[i], sectors[i], kSectorBytes)) return fail(std::strerror(errno));
  }
  return 0;
}

int try_slot(char slot, int tries) {
  if (!read_sectors()) return fail(std::strerror(errno));
  SlotState state;
  read_state(sectors[0], sectors[1], state);
  if (state.good == slot) return fail("that slot is the good one");
  state.trial = slot;
  state.left = tries;
  return set_state(state);
}

// ---- the last partition ------------------------------------------------------------------------

uint64_t disk_sectors() {
  uint64_t bytes = 0;
  if (ioctl(fd, BLKGETSIZE64, &bytes) == 0) return bytes / kSectorBytes;
  const off_t size = lseek(fd, 0, SEEK_END);
  return size < 0 ? 0 : static_cast<uint64_t>(size) / kSectorBytes;
}

// The first table, or its copy at the disk's end.
bool read_table(uint64_t size) {
  if (read_at(1, &table, sizeof table) && is_whole(table, 1)) return true;
  return read_at(size - 1, table.header, kSectorBytes) &&
         read_at(size - 1 - kEntrySectors, table.entries, sizeof table.entries) &&
         is_whole(table, size - 1);
}

// The copy first: until it is whole the first table is as it was.
bool write_table(uint64_t size) {
  make_copy(table, size, copy_of_header);
  return write_at(size - 1 - kEntrySectors, table.entries, sizeof table.entries) &&
         write_at(size - 1, copy_of_header, kSectorBytes) && write_at(1, &table, sizeof table);
}

// The kernel is told: it would read the table anew only if nothing on the disk were in use.
bool tell_kernel(const Grown& grown) {
  blkpg_partition partition{};
  partition.pno = grown.number;
  partition.start = static_cast<long long>(grown.first * kSectorBytes);
  partition.length = static_cast<long long>(grown.sectors * kSectorBytes);
  blkpg_ioctl_arg argument{BLKPG_RESIZE_PARTITION, 0, sizeof partition, &partition};
  return ioctl(fd, BLKPG, &argument) == 0 || errno == ENOTTY;  // a file, in tests
}

int grow_last() {
  const uint64_t size = disk_sectors();
  if (size < 2 * (kEntrySectors + 2) || !read_table(size)) return fail("no whole partition table");
  Grown grown;
  const Status status = grow(table, size, grown);
  if (status == Status::kEmpty) return 0;
  if (status != Status::kOk) return fail("its partition table is for a larger disk");
  if (!write_table(size) || !tell_kernel(grown)) return fail(std::strerror(errno));
  return 0;
}

int obey(int argc, char** argv) {
  const char* const word = argc > 0 ? argv[0] : "";
  const char slot = argc > 1 && argv[1][1] == 0 && is_slot(argv[1][0]) ? argv[1][0] : char{0};
  if (argc == 1 && std::strcmp(word, "get") == 0) return get_state();
  if (argc == 1 && std::strcmp(word, "grow") == 0) return grow_last();
  if (argc == 2 && slot != 0 && std::strcmp(word, "good") == 0) return set_state({slot, 0, 0});
  if (argc == 3 && slot != 0 && std::strcmp(word, "try") == 0) {
    const int tries = argv[2][0] - '0';
    if (argv[2][1] == 0 && tries >= 1 && tries <= kTriesMax) return try_slot(slot, tries);
  }
  return usage();
}

int main_of(int argc, char** argv) {
  --argc, ++argv;
  if (argc > 1 && std::strcmp(argv[0], "--card") == 0) {
    card = argv[1];
    argc -= 2, argv += 2;
  }
  if (argc == 0) return usage();
  fd = open(card, O_RDWR | O_DIRECT | O_CLOEXEC);
  if (fd < 0 && errno == EINVAL) fd = open(card, O_RDWR | O_CLOEXEC);  // a file on tmpfs
  if (fd < 0) return fail(std::strerror(errno));
  return obey(argc, argv);
}

}  // namespace
}  // namespace pirvs::card

int main(int argc, char** argv) { return pirvs::card::main_of(argc, argv); }
