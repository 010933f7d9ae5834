# Writes a source that embeds files: cmake "-DFILES=PATH;PATH" -DFUNCTION=NAME -DOUTPUT=FILE.cpp -P embed_files.cmake
# The assembler reads the files (.incbin), so that large files cost no compile time. The source has their hashes, so that
# it changes with their bytes.
set(number 0)
set(assembly "")
set(declarations "")
set(entries "")
foreach(path ${FILES})
  cmake_path(GET path FILENAME name)
  if(NOT name MATCHES "^[A-Za-z0-9][A-Za-z0-9._-]*$")
    message(FATAL_ERROR "${path}: the name of an embedded file has only letters, digits and . _ -")
  endif()
  set(symbol ${FUNCTION}_${number})
  file(SHA256 ${path} hash)
  string(SUBSTRING ${hash} 0 32 hash)
  string(APPEND assembly
    "  .globl ${symbol}\n  .hidden ${symbol}\n  .balign 16\n${symbol}:\n  .incbin \"${path}\"\n"
    "  .globl ${symbol}_end\n  .hidden ${symbol}_end\n${symbol}_end:\n  .byte 0\n")
  string(APPEND declarations "extern \"C\" const std::byte ${symbol}[], ${symbol}_end[];\n")
  string(APPEND entries "    {\"${name}\", {${symbol}, ${symbol}_end}, \"${hash}\"},\n")
  math(EXPR number "${number} + 1")
endforeach()

set(body "  return {};\n")
if(number GREATER 0)
  string(PREPEND declarations "asm(R\"(\n  .section .rodata\n${assembly}  .previous\n)\");\n\n")
  set(body "  static const PageFile files[] = {\n${entries}  };\n  return files;\n")
endif()
file(WRITE ${OUTPUT}
  "#include \"server/page/page_files.h\"\n\n${declarations}\nnamespace lode::page {\n\n"
  "std::span<const PageFile> ${FUNCTION}() noexcept {\n${body}}\n\n}  // namespace lode::page\n")
