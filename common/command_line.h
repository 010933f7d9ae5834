#pragma once

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <new>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/error.h"
#include "common/printable.h"

/// Command lines and exit statuses of both programs. Header only, so that CLI11, which takes seconds to
/// compile, is compiled only for commands.
namespace lode {

namespace command_line {

constexpr int kDone = 0, kWorkFailed = 1, kWrongUsage = 2;

/// Prints an error on one line of stderr. @return the argument `status`.
inline int fail(const CLI::App& program, const std::string& message, int status) {
  printOnOneLine(program.get_name(), message);
  return status;
}

/// Ends a command that has printed its result. @return `status`, or kWorkFailed if stdout could not be
/// written.
inline int endAfterPrinting(const CLI::App& program, int status) {
  if (std::cout.flush() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
  return fail(program, std::string("cannot write to standard output: ") + std::strerror(errno), kWorkFailed);
}

/// Returns the message of an error for a program without remedies of its own.
inline std::string plainMessage(const Error& error) { return error.what(); }

/// Returns true if the program has a command of this name.
inline bool hasCommand(const CLI::App& program, std::string_view name) {
  const auto is_named = [name](const CLI::App* command) { return command->get_name() == name; };
  return !program.get_subcommands(is_named).empty();
}

/// Returns the message about unknown words. A first word without a dash counts as a mistyped command, because
/// only options can precede the command.
inline std::string unknownInWords(const CLI::App& program, const std::vector<std::string>& unknown) {
  if (program.get_subcommands().empty() && !unknown.front().starts_with('-'))
    return "unknown command: " + unknown.front();
  return "not known here: " + CLI::detail::join(unknown, " ");
}

/// Returns the end of a message about wrong usage: "see lodestream fetch --help".
inline std::string helpHint(const CLI::App& program) {
  std::string words = "see " + program.get_name();
  for (const CLI::App* command : program.get_subcommands()) words += " " + command->get_name();
  return words + " --help";
}

}  // namespace command_line

/// Command to run if the command line does not begin with a command.
struct DefaultCommand {
  const char* name = nullptr;  ///< name of the command; null: such a command line is wrong
  /// Returns true if the first word is an argument of the default command, false if it is a mistyped command.
  bool (*takes)(std::string_view first_word) = nullptr;
  /// Returns true if the command also runs for an empty command line; null: false.
  bool (*stands_alone)() = nullptr;
};

namespace command_line {

/// Returns the words of a command line. Puts the default command in front if the words begin with an argument
/// of this command, or if there are no words and the command stands alone.
inline std::vector<const char*> withDefaultCommand(const CLI::App& program, int argc, const char* const* argv,
                                                   const DefaultCommand& default_command) {
  std::vector<const char*> words(argv, argv + argc);
  if (default_command.name == nullptr) return words;
  const auto isOption = [](std::string_view word) { return word.size() > 1 && word.front() == '-'; };
  const bool is_default =
      words.size() > 1
          ? !isOption(words[1]) && !hasCommand(program, words[1]) && default_command.takes(words[1])
          : default_command.stands_alone != nullptr && default_command.stands_alone();
  if (is_default) words.insert(words.begin() + 1, default_command.name);
  return words;
}

}  // namespace command_line

/// A program's own wording and its default command, for runCommandLine().
struct ProgramTraits {
  const char* more_memory;  ///< remedy in the message about exhausted memory
  /// Returns the message of an error; a program can add its own wording of the remedy.
  std::string (*message_of)(const Error&) = command_line::plainMessage;
  /// Command to run if the first word is neither a command nor an option, but an argument of this command.
  DefaultCommand default_command = {};
};

/// Returns a validator that accepts numbers from `least` to `most`. CLI::Range() would also accept "nan".
inline CLI::Validator numberFrom(double least, double most) {
  std::ostringstream range;
  range << '[' << least << " - " << most << ']';
  const auto check = [least, most, range = range.str()](const std::string& text) {
    double number = 0;
    const bool is_within = CLI::detail::lexical_cast(text, number) && number >= least && number <= most;
    return is_within ? std::string() : "must be a number in " + range + ", not " + text;
  };
  return CLI::Validator(check, "FLOAT in " + range.str());
}

/// Adds --textures to a command that opens PLY files.
inline void addTexturesFolder(CLI::App& command, std::filesystem::path& folder) {
  command
      .add_option("--textures", folder,
                  "folder to search first for the images that a PLY file names (default: the PLY file's)")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
}

/// Parses the command line and runs the command. Prints errors on one line of stderr.
/// @param declare  adds the commands. A command's callback throws Error on failure and may set the exit
/// status.
/// @return the exit status: 0 for success, 1 if the work failed, 2 for wrong usage.
inline int runCommandLine(CLI::App& program, int argc, const char* const* argv,
                          const std::function<void(int& exit_status)>& declare, const ProgramTraits& traits) {
  using namespace command_line;
  int exit_status = kDone;
  try {
    program.require_subcommand(1);
    declare(exit_status);
    const std::vector<const char*> words = withDefaultCommand(program, argc, argv, traits.default_command);
    program.parse(static_cast<int>(words.size()), words.data());
    return endAfterPrinting(program, exit_status);
  } catch (const CLI::Success& asked) {  // --help, --version
    return endAfterPrinting(program, program.exit(asked));
  } catch (const CLI::ParseError& error) {
    const std::vector<std::string> unknown = program.remaining(true);
    const std::string what = unknown.empty() ? error.what() : unknownInWords(program, unknown);
    return fail(program, what + ": " + helpHint(program), kWrongUsage);
  } catch (const Error& error) {
    return fail(program, traits.message_of(error),
                error.code() == ErrorCode::kUsage ? kWrongUsage : kWorkFailed);
  } catch (const std::bad_alloc&) {
    return fail(program, std::string("out of memory: ") + traits.more_memory, kWorkFailed);
  } catch (const std::exception& error) {
    return fail(program, error.what(), kWorkFailed);
  }
}

}  // namespace lode
