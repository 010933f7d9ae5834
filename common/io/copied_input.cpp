#include "common/io/copied_input.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include "common/byte_size.h"
#include "common/error.h"
#include "common/io/file_io.h"
#include "common/io/foreign_file.h"

namespace lode {
namespace {

namespace fs = std::filesystem;

constexpr size_t kCopyBufferBytes = 1 << 20;
constexpr const char* kInput = "standard input";

/// Reads until `bytes` is full or the input ends. @return number of bytes read. @throws Error kIo.
size_t readFully(int input, std::span<char> bytes) {
  size_t got = 0;
  while (got < bytes.size()) {
    const ssize_t more = ::read(input, bytes.data() + got, bytes.size() - got);
    if (more == 0) break;
    if (more > 0) {
      got += static_cast<size_t>(more);
    } else if (errno == EAGAIN) {
      pollfd ready{input, POLLIN, 0};
      (void)::poll(&ready, 1, -1);
    } else if (errno != EINTR) {
      throw Error(ErrorCode::kIo, std::string(kInput) + " cannot be read: " + std::strerror(errno) +
                                      "; save the model to a file, and name the file");
    }
  }
  return got;
}

/// @param head  first bytes of the input. @throws Error kInput.
void refuseUnlessPly(std::string_view head) {
  if (head.starts_with("ply\n") || head.starts_with("ply\r")) return;
  const auto foreign = foreignFileInWords(kInput, head);
  throw Error(ErrorCode::kInput,
              std::string(kInput) + " " +
                  foreign.value_or("is not a PLY file; only PLY files can be read from a pipe"));
}

/// A file that is open for writing.
class NewFile {
 public:
  explicit NewFile(const fs::path& path)
      : path_(path), file_(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600)) {
    if (file_ < 0) refuse();
  }
  ~NewFile() {
    if (file_ >= 0) ::close(file_);
  }
  NewFile(NewFile&&) = delete;
  NewFile& operator=(NewFile&&) = delete;

  void write(std::span<const char> bytes) {
    if (!append(file_, std::as_bytes(bytes))) refuse();
  }

 private:
  [[noreturn]] void refuse() const {
    throw Error(ErrorCode::kIo,
                path_.string() + ", a copy of " + kInput + ", cannot be written: " + fileErrorInWords(errno));
  }

  const fs::path& path_;
  const int file_;
};

void copy(int input, const fs::path& path, uint64_t max_bytes) {
  const auto buffer = std::make_unique_for_overwrite<char[]>(kCopyBufferBytes);
  const std::span<char> bytes(buffer.get(), kCopyBufferBytes);
  size_t got = readFully(input, bytes.first(kForeignHeadBytes));
  refuseUnlessPly({bytes.data(), got});
  NewFile file(path);
  for (uint64_t copied = 0; got > 0; got = readFully(input, bytes)) {
    if (got > max_bytes - copied)
      throw Error(ErrorCode::kLimit, std::string(kInput) + " is longer than " + describeBytes(max_bytes) +
                                         ", the limit for its copy in " +
                                         path.parent_path().parent_path().string() +
                                         "; free some space, or save the model to a file, and name the file");
    file.write(bytes.first(got));
    copied += got;
  }
}

}  // namespace

bool namesStandardInput(std::string_view name) noexcept { return name == "-" || name == "/dev/stdin"; }

CopiedInput::CopiedInput(int input, const fs::path& parent, uint64_t max_bytes) {
  if (::isatty(input) == 1)
    throw Error(ErrorCode::kUsage, std::string(kInput) +
                                       " is a terminal; pipe a PLY file into the program, such as "
                                       "`xzcat MODEL.ply.xz | ...`, or name a file");
  std::string folder = (parent / ".lodestream-input-XXXXXX").string();
  {
    const Uninterrupted until_it_is_known;
    if (::mkdtemp(folder.data()) == nullptr)
      throw Error(ErrorCode::kIo, "cannot make a folder for a copy of " + std::string(kInput) + " in " +
                                      parent.string() + ": " + std::strerror(errno) +
                                      "; save the model to a file, and name the file");
    unfinished_ = Unfinished(folder);
  }
  path_ = fs::path(folder) / "standard-input.ply";
  try {
    copy(input, path_, max_bytes);
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    throw;
  }
}

CopiedInput::~CopiedInput() {
  std::error_code ignored;
  fs::remove_all(path_.parent_path(), ignored);
}

uint64_t copyBytesIn(const fs::path& folder) {
  std::error_code failed;
  const fs::space_info disk = fs::space(folder, failed);
  return failed ? 0 : uint64_t{disk.available} / 2;
}

}  // namespace lode
