#include "board/card/partition_table.h"

#include <cstring>

#include "core/base/crc32.h"

namespace pirvs::card {
namespace {

// Offsets in the header and in an entry.
constexpr size_t kHeaderBytes = 92, kHeaderCrc = 16, kMyLba = 24, kOtherLba = 32, kLastUsable = 48,
                 kEntriesLba = 72, kEntriesCount = 80, kEntrySize = 84, kEntriesCrc = 88;
constexpr size_t kFirstLba = 32, kLastLba = 40;

uint64_t get(const uint8_t* at, size_t bytes) {
  uint64_t value = 0;
  for (size_t i = bytes; i-- > 0;) value = value << 8 | at[i];
  return value;
}

void set(uint8_t* at, size_t bytes, uint64_t value) {
  for (size_t i = 0; i < bytes; ++i) at[i] = static_cast<uint8_t>(value >> 8 * i);
}

uint32_t crc_of(const uint8_t* bytes, size_t size) {
  Crc32 crc;
  crc.add(bytes, size);
  return crc.value();
}

uint32_t header_crc(const Sector& header) {
  Sector zeroed;
  std::memcpy(zeroed, header, sizeof zeroed);
  set(zeroed + kHeaderCrc, 4, 0);
  return crc_of(zeroed, kHeaderBytes);
}

void seal(Sector& header, const PartitionTable& table) {
  set(header + kEntriesCrc, 4, crc_of(table.entries, sizeof table.entries));
  set(header + kHeaderCrc, 4, header_crc(header));
}

// The entry that ends last.
uint8_t* last_entry(PartitionTable& table) {
  uint8_t* found = nullptr;
  for (size_t i = 0; i < kEntries; ++i) {
    uint8_t* const entry = table.entries + i * kEntryBytes;
    if (get(entry + kLastLba, 8) == 0) continue;
    if (found == nullptr || get(entry + kLastLba, 8) > get(found + kLastLba, 8)) found = entry;
  }
  return found;
}

}  // namespace

bool is_whole(const PartitionTable& table, uint64_t header_sector) {
  const uint8_t* const header = table.header;
  return std::memcmp(header, "EFI PART", 8) == 0 && get(header + 12, 4) == kHeaderBytes &&
         get(header + kHeaderCrc, 4) == header_crc(table.header) &&
         get(header + kMyLba, 8) == header_sector && get(header + kEntriesCount, 4) == kEntries &&
         get(header + kEntrySize, 4) == kEntryBytes &&
         get(header + kEntriesCrc, 4) == crc_of(table.entries, sizeof table.entries);
}

Status grow(PartitionTable& table, uint64_t disk_sectors, Grown& out) {
  uint8_t* const entry = last_entry(table);
  if (entry == nullptr) return Status::kBadData;
  const uint64_t last_usable = disk_sectors - kEntrySectors - 2;
  const uint64_t end = (last_usable + 1) / kAlignment * kAlignment;
  const uint64_t begin = get(entry + kFirstLba, 8), end_now = get(entry + kLastLba, 8) + 1;
  if (end_now > end) return end_now > last_usable + 1 ? Status::kFull : Status::kEmpty;
  if (end_now == end && get(table.header + kOtherLba, 8) == disk_sectors - 1) return Status::kEmpty;
  set(entry + kLastLba, 8, end - 1);
  set(table.header + kMyLba, 8, 1);
  set(table.header + kOtherLba, 8, disk_sectors - 1);
  set(table.header + kLastUsable, 8, last_usable);
  set(table.header + kEntriesLba, 8, 2);
  seal(table.header, table);
  out.number = static_cast<int>((entry - table.entries) / static_cast<long>(kEntryBytes)) + 1;
  out.first = begin;
  out.sectors = end - begin;
  return Status::kOk;
}

void make_copy(const PartitionTable& table, uint64_t disk_sectors, Sector& header) {
  std::memcpy(header, table.header, sizeof header);
  set(header + kMyLba, 8, disk_sectors - 1);
  set(header + kOtherLba, 8, 1);
  set(header + kEntriesLba, 8, disk_sectors - 1 - kEntrySectors);
  seal(header, table);
}

}  // namespace pirvs::card
