#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace lode::app {

/// Choices of the user about one model, which a file cannot know. Empty strings: no choice.
struct ModelChoices {
  std::string up;    ///< up axis as parseAxis() reads it
  std::string unit;  ///< unit of length, one of kUnits (settings.h)

  bool operator==(const ModelChoices&) const = default;
};

/// Keeps the choices about one model for the next time that it is opened, in a small file of a folder.
class KeptChoices {
 public:
  /// @param folder  folder of the program; created when choices are kept.
  /// @param target  target of the model. A local file is known by its absolute path.
  KeptChoices(const std::filesystem::path& folder, std::string_view target);

  /// Returns the kept choices. Ignores a file that is missing, too long or has other contents.
  ModelChoices read() const;
  /// Keeps choices. If the folder cannot be written, the choices last until the window is closed.
  void keep(const ModelChoices& choices) const;

 private:
  std::filesystem::path folder_, file_;
};

}  // namespace lode::app
