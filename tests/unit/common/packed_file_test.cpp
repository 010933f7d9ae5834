#include "common/io/packed_file.h"

#include <gtest/gtest.h>

namespace lode {
namespace {

using namespace std::string_literals;

TEST(PackedFile, isRecognizedByItsFirstBytesAndNamesTheCommand) {
  struct Case {
    std::string path, head, text;
  };
  const Case cases[] = {
      {"a/scan.ply.gz", "\x1f\x8b\x08",
       "is compressed with gzip; unpack it first: gzip -dc a/scan.ply.gz > a/scan.ply"},
      {"scan.ply.bz2", "BZh91AY",
       "is compressed with bzip2; unpack it first: bzip2 -dc scan.ply.bz2 > scan.ply"},
      {"scan.ply.xz", "\xfd\x37zXZ\0\0"s,
       "is compressed with xz; unpack it first: xz -dc scan.ply.xz > scan.ply"},
      {"scan.ply.zst", "\x28\xb5\x2f\xfd\x04",
       "is compressed with zstd; unpack it first: zstd -dc scan.ply.zst > scan.ply"},
      {"scan.ply.lz4", "\x04\x22\x4d\x18",
       "is compressed with lz4; unpack it first: lz4 -dc scan.ply.lz4 > scan.ply"},
      {"scan.Z", "\x1f\x9d\x90", "is compressed with compress; unpack it first: gzip -dc scan.Z > scan.ply"},
      {"scan.ply", "BZh91AY",
       "is compressed with bzip2; unpack it first: bzip2 -dc scan.ply > scan.unpacked.ply"},
      {"scan.lode.xz", "\xfd\x37zXZ\0"s,
       "is compressed with xz; unpack it first: xz -dc scan.lode.xz > scan.lode"},
      {"scan.tar.xz", "\xfd\x37zXZ\0"s, "is compressed with xz; unpack it first: tar -xf scan.tar.xz"},
      {"scan.tgz", "\x1f\x8b", "is compressed with gzip; unpack it first: tar -xf scan.tgz"},
      {"scan.zip", "PK\x03\x04", "is a zip archive; unpack it first: unzip scan.zip"},
      {"scan.7z", "7z\xbc\xaf\x27\x1c", "is a 7z archive; unpack it first: 7z x scan.7z"},
      {"my scan's.xz", "\xfd\x37zXZ\0"s,
       R"(is compressed with xz; unpack it first: xz -dc 'my scan'\''s.xz' > 'my scan'\''s.ply')"},
  };
  for (const Case& each : cases) EXPECT_EQ(packedFileInWords(each.path, each.head), each.text);
}

TEST(PackedFile, isAlsoATarArchive) {
  EXPECT_EQ(packedFileInWords("a.tar", std::string(257, 'x') + "ustar"),
            "is a tar archive; unpack it first: tar -xf a.tar");
}

TEST(PackedFile, isNoOtherFile) {
  for (const std::string head : {"ply\n", "", "\x1f", "BZ", "LODE\r\n", "solid", "PK"})
    EXPECT_FALSE(packedFileInWords("a.ply", head)) << head;
}

}  // namespace
}  // namespace lode
