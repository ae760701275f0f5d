// The state of the slots as U-Boot reads and writes it, and the partition table that grows.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "board/card/partition_table.h"
#include "board/card/receive/lines.h"
#include "board/card/slot_state.h"
#include "core/base/crc32.h"

namespace pirvs::card {
namespace {

// ---- the state ---------------------------------------------------------------------------------

struct Sectors {
  Sector first, second;

  explicit Sectors(const SlotState& state) {
    put_state(state, first);
    put_state(state, second);
  }
  StateFrom read(SlotState& out) const { return read_state(first, second, out); }
};

TEST(slot_state, what_is_written_is_read) {
  for (const char good : {'a', 'b'}) {
    for (const char trial : {char{0}, 'a', 'b'}) {
      for (int left = 0; left <= kTriesMax; ++left) {
        const SlotState state = {good, trial, left};
        SlotState out;
        EXPECT_EQ(Sectors(state).read(out), StateFrom::kFirst);
        EXPECT_TRUE(out == state) << good << int{trial} << left;
      }
    }
  }
}

// As `env export -c -s 200 addr good trial left` leaves it: the same text, the order by name.
TEST(slot_state, is_what_u_boot_exports) {
  Sector sector;
  put_state({'a', 'b', 2}, sector);
  const char text[] = "good=a\0left=2\0trial=b\0";
  EXPECT_EQ(std::memcmp(sector + 4, text, sizeof text), 0);
  Crc32 crc;
  crc.add(sector + 4, kSectorBytes - 4);
  const uint32_t stored = uint32_t{sector[0]} | uint32_t{sector[1]} << 8 |
                          uint32_t{sector[2]} << 16 | uint32_t{sector[3]} << 24;
  EXPECT_EQ(stored, crc.value());
}

// A cut in the middle of the first sector's write leaves old and new bytes in it.
TEST(slot_state, a_torn_first_sector_leaves_the_old_state) {
  const SlotState before = {'a', 0, 0}, after = {'b', 'a', 3};
  const Sectors written(after);
  for (size_t cut = 1; cut < kSectorBytes; ++cut) {
    Sectors sectors(before);
    std::memcpy(sectors.first, written.first, cut);
    if (std::memcmp(sectors.first, written.first, kSectorBytes) == 0) continue;
    SlotState out;
    ASSERT_EQ(sectors.read(out), StateFrom::kSecond) << cut;
    ASSERT_TRUE(out == before) << cut;
  }
}

TEST(slot_state, a_torn_second_sector_leaves_the_new_one) {
  Sectors sectors({'b', 'a', 3});
  Sector old;
  put_state({'a', 0, 0}, old);
  std::memcpy(sectors.second + 10, old + 10, 100);
  SlotState out;
  EXPECT_EQ(sectors.read(out), StateFrom::kFirst);
  EXPECT_TRUE(out == (SlotState{'b', 'a', 3}));
}

TEST(slot_state, without_a_whole_sector_slot_a_is_good) {
  Sectors sectors({'b', 0, 0});
  sectors.first[100] ^= 1;
  sectors.second[0] ^= 1;  // the CRC itself
  SlotState out = {'b', 'b', 1};
  EXPECT_EQ(sectors.read(out), StateFrom::kNeither);
  EXPECT_TRUE(out == SlotState{});
  Sector zeros{}, ones;
  std::memset(ones, 0xff, sizeof ones);
  EXPECT_EQ(read_state(zeros, ones, out), StateFrom::kNeither) << "a card that was never written";
}

void seal(Sector& sector) {
  Crc32 crc;
  crc.add(sector + 4, kSectorBytes - 4);
  for (size_t i = 0; i < 4; ++i) sector[i] = static_cast<uint8_t>(crc.value() >> 8 * i);
}

TEST(slot_state, a_whole_sector_without_sense_is_passed_over) {
  for (const std::string text : {"good=c", "left=1", "good=", "goods=a", "good=ab"}) {
    Sectors sectors({'b', 0, 0});
    std::memset(sectors.first, 0, kSectorBytes);
    std::memcpy(sectors.first + 4, text.data(), text.size());
    seal(sectors.first);
    SlotState out;
    EXPECT_EQ(sectors.read(out), StateFrom::kSecond) << text;
    EXPECT_EQ(out.good, 'b');
  }
  Sector full;  // no zero anywhere
  std::memset(full, 'x', sizeof full);
  seal(full);
  SlotState out;
  EXPECT_EQ(read_state(full, full, out), StateFrom::kNeither);
}

// ---- the partition table -----------------------------------------------------------------------

void set(uint8_t* at, size_t bytes, uint64_t value) {
  for (size_t i = 0; i < bytes; ++i) at[i] = static_cast<uint8_t>(value >> 8 * i);
}

uint64_t get(const uint8_t* at) {
  uint64_t value = 0;
  for (size_t i = 8; i-- > 0;) value = value << 8 | at[i];
  return value;
}

constexpr uint64_t kImageSectors = 100'000, kDiskSectors = 4'000'000;

// Two partitions, the second ends at `end`.
PartitionTable table_of(uint64_t end) {
  PartitionTable table{};
  set(table.entries, 8, 1), set(table.entries + 32, 8, 2048), set(table.entries + 40, 8, 4095);
  uint8_t* const last = table.entries + kEntryBytes;
  set(last, 8, 1), set(last + 32, 8, 4096), set(last + 40, 8, end - 1);
  std::memcpy(table.header, "EFI PART\0\0\1\0\x5c\0\0\0", 16);
  set(table.header + 24, 8, 1), set(table.header + 32, 8, kImageSectors - 1);
  set(table.header + 40, 8, 34), set(table.header + 48, 8, kImageSectors - 34);
  set(table.header + 72, 8, 2), set(table.header + 80, 4, kEntries);
  set(table.header + 84, 4, kEntryBytes);
  Sector copy;  // sealed by way of a copy of a copy
  make_copy(table, kImageSectors, copy);
  set(table.header + 88, 4, 0);
  std::memcpy(table.header + 88, copy + 88, 4);
  Crc32 crc;
  set(table.header + 16, 4, 0);
  crc.add(table.header, 92);
  set(table.header + 16, 4, crc.value());
  return table;
}

TEST(partition_table, the_last_partition_takes_what_is_free) {
  PartitionTable table = table_of(90'112);
  ASSERT_TRUE(is_whole(table, 1));
  Grown grown;
  ASSERT_EQ(grow(table, kDiskSectors, grown), Status::kOk);
  EXPECT_TRUE(is_whole(table, 1));
  EXPECT_EQ(grown.number, 2);
  EXPECT_EQ(grown.first, 4096u);
  EXPECT_EQ((grown.first + grown.sectors) % kAlignment, 0u);
  EXPECT_EQ(get(table.entries + kEntryBytes + 40) + 1, grown.first + grown.sectors);
  EXPECT_LE(grown.first + grown.sectors, kDiskSectors - kEntrySectors - 1);
  EXPECT_GT(grown.first + grown.sectors, kDiskSectors - kEntrySectors - 1 - kAlignment);
  EXPECT_EQ(get(table.entries + 40), 4095u) << "the first one stays";
  PartitionTable copy = table;
  make_copy(table, kDiskSectors, copy.header);
  EXPECT_TRUE(is_whole(copy, kDiskSectors - 1));
  EXPECT_FALSE(is_whole(copy, 1));
  EXPECT_EQ(grow(table, kDiskSectors, grown), Status::kEmpty) << "once is enough";
}

TEST(partition_table, the_copy_alone_gives_the_same) {
  PartitionTable table = table_of(90'112), copy = table;
  make_copy(table, kImageSectors, copy.header);
  Grown grown;
  ASSERT_EQ(grow(table, kDiskSectors, grown), Status::kOk);
  ASSERT_EQ(grow(copy, kDiskSectors, grown), Status::kOk);
  EXPECT_EQ(std::memcmp(&table, &copy, sizeof table), 0);
}

TEST(partition_table, refuses_what_is_damaged_or_too_large) {
  PartitionTable table = table_of(90'112);
  for (const size_t at : {size_t{0}, size_t{50}, size_t{91}}) {
    table.header[at] ^= 1;
    EXPECT_FALSE(is_whole(table, 1)) << at;
    table.header[at] ^= 1;
  }
  table.entries[5000] ^= 1;
  EXPECT_FALSE(is_whole(table, 1));
  table.entries[5000] ^= 1;
  Grown grown;
  EXPECT_EQ(grow(table, 50'000, grown), Status::kFull);
  PartitionTable empty{};
  EXPECT_EQ(grow(empty, kDiskSectors, grown), Status::kBadData);
}

// ---- lines -------------------------------------------------------------------------------------

TEST(update_lines, requests) {
  EXPECT_EQ(parse_request("pirvs 1 version").kind, Request::Kind::kVersion);
  const Request update = parse_request("pirvs 1 update 36000000\r");
  EXPECT_EQ(update.kind, Request::Kind::kUpdate);
  EXPECT_EQ(update.bytes, 36'000'000u);
  for (const char* text :
       {"", "pirvs", "pirvs 2 version", "pirvs 1 update", "pirvs 1 update 0", "pirvs 1 update -1",
        "pirvs 1 update 99999999999999999999", "pirvs 1 update 600000000", "pirvs 1 update 12x",
        "pirvs 1 versions", "GET / HTTP/1.1"}) {
    EXPECT_EQ(parse_request(text).kind, Request::Kind::kNone) << text;
  }
}

TEST(update_lines, what_rauc_says) {
  const RaucLine step = parse_rauc(" 40% Checking bundle done.");
  EXPECT_EQ(step.kind, RaucLine::Kind::kProgress);
  EXPECT_EQ(step.percent, 40);
  EXPECT_EQ(step.text, "Checking bundle done.");
  const RaucLine error = parse_rauc("LastError: signature verification failed: self-signed");
  EXPECT_EQ(error.kind, RaucLine::Kind::kError);
  EXPECT_EQ(error.text, "signature verification failed: self-signed");
  for (const char* text :
       {"installing", "idle", "", "% ", "101% much", "Installing `x` succeeded"}) {
    EXPECT_EQ(parse_rauc(text).kind, RaucLine::Kind::kNone) << text;
  }
}

TEST(update_lines, values) {
  EXPECT_EQ(find_value("NAME=\"PIRVS\"\nVERSION_ID=2-a\nX=1", "VERSION_ID"), "2-a");
  EXPECT_EQ(find_value("NAME=\"PIRVS\"", "NAME"), "PIRVS");
  EXPECT_EQ(find_value("NAME=x", "NAM"), "");
  EXPECT_EQ(find_word("quiet panic=2 rauc.slot=b\n", "rauc.slot"), "b");
  EXPECT_EQ(find_word("quiet", "rauc.slot"), "");
}

}  // namespace
}  // namespace pirvs::card
