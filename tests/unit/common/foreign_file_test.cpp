#include "common/io/foreign_file.h"

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
  for (const Case& each : cases) EXPECT_EQ(foreignFileInWords(each.path, each.head), each.text);
}

TEST(PackedFile, isAlsoATarArchive) {
  EXPECT_EQ(foreignFileInWords("a.tar", std::string(257, 'x') + "ustar"),
            "is a tar archive; unpack it first: tar -xf a.tar");
}

TEST(ForeignFile, isRecognizedAsAMeshOfAnotherFormat) {
  struct Case {
    std::string path, head, name, way;
  };
  const Case cases[] = {
      {"model.obj", "# Blender\nmtllib m.mtl\nv 0 0 0\n", "an OBJ",
       "MeshLab, Blender, `assimp export model.obj model.ply`"},
      {"m.glb", "glTF\2\0\0\0\xff\xff\xff\xff"s, "a GLB (binary glTF)",
       "MeshLab, Blender, `assimp export m.glb m.ply`"},
      {"m.gltf", "\n{ \"scenes\": [", "a glTF", "MeshLab, Blender, `assimp export m.gltf m.ply`"},
      {"m", R"({"asset":{"version":"2.0"},)", "a glTF", "MeshLab, Blender, `assimp export m m.ply`"},
      {"m.stl", "solid m\nfacet normal 0 0 1\n", "an STL", "MeshLab, Blender, `assimp export m.stl m.ply`"},
      {"M.STL", std::string(80, '\0') + "\xff\xff\xff\xff", "an STL",
       "MeshLab, Blender, `assimp export M.STL M.ply`"},
      {"m.fbx", "Kaydara FBX Binary  \0\x1a\0"s, "an FBX", "Blender, `assimp export m.fbx m.ply`"},
      {"a.fbx", "; FBX 7.3.0 project file\n", "an FBX", "Blender, `assimp export a.fbx a.ply`"},
      {"m.3mf", "PK\x03\x04\x14\0\0\0"s, "a 3MF", "MeshLab, `assimp export m.3mf m.ply`"},
      {"m.zip", "PK\x03\x04\x14\0\0\0\x08\0 3D/3dmodel.model"s, "a 3MF",
       "MeshLab, `assimp export m.zip m.ply`"},
      {"m.off", "OFF\n8 6 0\n", "an OFF", "MeshLab, `assimp export m.off m.ply`"},
      {"m", "COFF 8 6 0\n", "an OFF", "MeshLab, `assimp export m m.ply`"},
      {"m.dae", "<?xml version=\"1.0\"?>\n<COLLADA ", "a COLLADA",
       "MeshLab, Blender, `assimp export m.dae m.ply`"},
      {"m.usdc", "PXR-USDC", "a USD", "Blender"},
      {"m.blend", "BLENDER-v300", "a Blender file", "Blender"},
      {"m.step", "ISO-10303-21;\n", "a STEP", "FreeCAD"},
      {"my scan.ply", "glTF\2\0\0\0"s, "a GLB (binary glTF)",
       "MeshLab, Blender, `assimp export 'my scan.ply' 'my scan.converted.ply'`"},
  };
  for (const Case& each : cases)
    EXPECT_EQ(foreignFileInWords(each.path, each.head),
              "is " + each.name + ", neither a PLY file nor a store; Lodestream reads PLY: convert it (" +
                  each.way + ")")
        << each.path;
}

TEST(ForeignFile, isRecognizedAsAPictureWhateverItsName) {
  struct Case {
    std::string path, head, name;
  };
  const Case cases[] = {
      {"a.png", "\x89PNG\r\n\x1a\n", "a PNG"},
      {"a.ply", "\xff\xd8\xff\xe0", "a JPEG"},
      {"a.gif", "GIF89a", "a GIF"},
      {"a.webp", "RIFF\xff\xff\xff\xffWEBPVP8 ", "a WebP"},
      {"a.tif", "II*\0\x08"s, "a TIFF"},
      {"a.tif", "MM\0*\0"s, "a TIFF"},
      {"a.exr", "\x76\x2f\x31\x01\x02", "an OpenEXR"},
      {"a.bmp", "BM\x36", "a BMP"},
  };
  for (const Case& each : cases)
    EXPECT_EQ(foreignFileInWords(each.path, each.head),
              "is " + each.name + " picture, neither a PLY file nor a store; name the PLY file of the mesh");
}

TEST(ForeignFile, isRecognizedAsAPointCloud) {
  EXPECT_EQ(foreignFileInWords("a.las", "LASF\0\0"s),
            "is a LAS point cloud, neither a PLY file nor a store; make a mesh of its points first (MeshLab, "
            "CloudCompare)");
  for (const std::string head : {"ASTM-E57\1", "# .PCD v0.7 - Point Cloud Data"})
    EXPECT_NE(foreignFileInWords("a", head).value_or("").find("point cloud"), std::string::npos) << head;
}

TEST(ForeignFile, isRecognizedIfItStandsForAnotherFile) {
  EXPECT_EQ(foreignFileInWords("a.ply", ""), "is empty; copy or export it again");
  EXPECT_EQ(foreignFileInWords("a.ply", "version https://git-lfs.github.com/spec/v1\n"),
            "is a Git LFS pointer, not the file itself; fetch the file with: git lfs pull");
  for (const std::string head : {"<!DOCTYPE html>\n<html>", "\n<html lang=\"en\">"})
    EXPECT_EQ(foreignFileInWords("a.ply", head),
              "is a web page, neither a PLY file nor a store; download the file that the page offers");
}

TEST(ForeignFile, isNoOtherFile) {
  struct Case {
    std::string path, head;
  };
  const Case cases[] = {
      {"a.ply", "ply\n"},
      {"a.obj", "ply\nformat"},
      {"a.stl", "LODE\r\n\x1a\n"},
      {"a.ply", "\x1f"},
      {"a.ply", "BZ"},
      {"a.lode", "LODE\r\n"},
      {"a.ply", "solid"},
      {"a.ply", "PK"},
      {"a.ply", "OFF"},
      {"a.ply", "OFFSET 1"},
      {"a.ply", "BMW"},
      {"a.ply", "RIFF"},
      {"a.ply", "{\"up\":"},
      {"a.ply", "# v 1 2 3\n"},
      {"a.obj", "\x4c\x01\0\0"s},
      {"a.ply", "\xef\xbb\xbfply\n"},
      {"a.ply", " ply\n"},
      {"", "x"},
  };
  for (const Case& each : cases) EXPECT_FALSE(foreignFileInWords(each.path, each.head)) << each.head;
}

TEST(ForeignFile, isExaminedOnlyAtItsStart) {
  EXPECT_FALSE(foreignFileInWords("a", "solid" + std::string(kForeignHeadBytes, ' ') + "facet"));
}

TEST(ForeignFile, isExaminedWithoutReadingPastItsEnd) {
  const std::string heads[] = {
      "glTF\2\0\0\0"s, "RIFF\xff\xff\xff\xffWEBP", "PK\x03\x04",     "COFF 1",
      "MM\0*"s,        "\xef\xbb\xbf{\"asset\"",   "<?xml <COLLADA", "<!doctype html"};
  for (const std::string& head : heads)
    for (size_t bytes = 0; bytes <= head.size(); ++bytes)
      for (const char* path : {"a.obj", "a.stl", "a.off", "a.3mf", "a.gltf", "a.bmp", "a"})
        // The view is followed by the rest of the head, the copy by a zero.
        EXPECT_EQ(foreignFileInWords(path, std::string_view(head).substr(0, bytes)),
                  foreignFileInWords(path, std::string(head, 0, bytes)))
            << path << ": " << bytes << " bytes of " << head;
}

}  // namespace
}  // namespace lode
