"""What a card for an RK3399 must hold, read back from the bytes of the image.

  sector 0      protective MBR
  sector 1      GPT, its copy in the last sector
  sector 64     idbloader.img, which the boot ROM looks for
  sector 16384  u-boot.itb, which idbloader.img looks for
  16 MiB        the only partition: FAT32, read by U-Boot
"""
import hashlib
import struct
import subprocess
import zlib

SECTOR = 512
IDBLOADER_SECTOR = 64
UBOOT_SECTOR = 16384
BOOT_OFFSET = 16 * 1024 * 1024
IDBLOADER_MAGIC = bytes.fromhex("3b8cdcfc")  # RC4 of the boot ROM's header mark 0x0ff0aa55
FIT_MAGIC = bytes.fromhex("d00dfeed")
# For genimage.
FIRMWARE_PARTITIONS = """partition idbloader {
    in-partition-table = false
    offset = 32K
    image = "idbloader.img"
  }
  partition uboot {
    in-partition-table = false
    offset = 8M
    image = "u-boot.itb"
  }"""


class Bad(Exception):
    """The image is not as it must be; says what and where."""


def read_at(image, offset, size):
    with open(image, "rb") as file:
        file.seek(offset)
        data = file.read(size)
    if len(data) != size:
        raise Bad(f"{image}: ends before byte {offset + size}")
    return data


def gpt_partitions(image, header_sector):
    """(first sector, last sector, name) of every entry of one copy of the GPT."""
    header = read_at(image, header_sector * SECTOR, SECTOR)
    if header[:8] != b"EFI PART":
        raise Bad(f"{image}: no GPT in sector {header_sector}")
    size, crc = struct.unpack_from("<II", header, 12)
    if not 92 <= size <= SECTOR:
        raise Bad(f"{image}: the GPT header in sector {header_sector} has {size} bytes")
    if zlib.crc32(header[:16] + bytes(4) + header[20:size]) != crc:
        raise Bad(f"{image}: the GPT header in sector {header_sector} is damaged")
    if struct.unpack_from("<Q", header, 24)[0] != header_sector:
        raise Bad(f"{image}: the GPT header in sector {header_sector} belongs elsewhere")
    table, count, entry_size, table_crc = struct.unpack_from("<QIII", header, 72)
    entries = read_at(image, table * SECTOR, count * entry_size)
    if zlib.crc32(entries) != table_crc:
        raise Bad(f"{image}: the GPT entries of sector {header_sector} are damaged")
    found = []
    for i in range(count):
        entry = entries[i * entry_size:(i + 1) * entry_size]
        if any(entry[:16]):
            first, last = struct.unpack_from("<QQ", entry, 32)
            found.append((first, last, entry[56:128].decode("utf-16-le").rstrip("\0")))
    return found


def boot_partition(image):
    """(first sector, last sector) of the FAT partition, the same in both copies of the GPT."""
    with open(image, "rb") as file:
        sectors = file.seek(0, 2) // SECTOR
    partitions = gpt_partitions(image, 1)
    if gpt_partitions(image, sectors - 1) != partitions:
        raise Bad(f"{image}: the two copies of the GPT differ")
    if len(partitions) != 1 or partitions[0][2] != "boot":
        raise Bad(f"{image}: one partition, boot, is expected; there are {partitions}")
    first, last, _ = partitions[0]
    if first * SECTOR != BOOT_OFFSET:
        raise Bad(f"{image}: the boot partition begins at byte {first * SECTOR}")
    return first, last


def check_firmware(image, firmware):
    for name, sector, magic in (("idbloader.img", IDBLOADER_SECTOR, IDBLOADER_MAGIC),
                                ("u-boot.itb", UBOOT_SECTOR, FIT_MAGIC)):
        with open(f"{firmware}/{name}", "rb") as file:
            wanted = file.read()
        if wanted[:4] != magic:
            raise Bad(f"{firmware}/{name}: begins with {wanted[:4].hex()}, not {magic.hex()}")
        if read_at(image, sector * SECTOR, len(wanted)) != wanted:
            raise Bad(f"{image}: {name} is not whole at sector {sector}")


def check_files(image, files, offset=BOOT_OFFSET):
    """Each file of the FAT partition at that byte, by path, equals its source."""
    for path, source in files.items():
        read = subprocess.run(["mtype", "-i", f"{image}@@{offset}", f"::{path}"],
                              capture_output=True, check=False)
        with open(source, "rb") as file:
            wanted = hashlib.file_digest(file, "sha256").digest()
        if read.returncode or hashlib.sha256(read.stdout).digest() != wanted:
            raise Bad(f"{image}: {path} is not {source}")


def check(image, firmware, files):
    """Raises Bad unless firmware (a folder, or None) and files are where they belong."""
    first, last = boot_partition(image)
    name = read_at(image, first * SECTOR + 82, 8)
    if name != b"FAT32   ":
        raise Bad(f"{image}: the boot partition is {name}, not FAT32")
    sectors = struct.unpack("<I", read_at(image, first * SECTOR + 32, 4))[0]
    if sectors > last - first + 1:
        raise Bad(f"{image}: the file system is larger than its partition")
    if firmware:
        check_firmware(image, firmware)
    check_files(image, files)
