#pragma once

// Creates, moves and removes files below a folder without following links, so that a folder that comes from somebody
// else, such as an unpacked dataset, cannot make this program change files outside of it.
//
// In functions that open or change something, `folder` must exist. It may be reached through links, because the user
// has named it. `file`, `from`, `to` and `below` are paths that begin with `folder`. All functions throw ForeignFile if
// a folder on the way down is a link or not a folder, and Error with path and reason for other failures.

#include <filesystem>
#include <string_view>

#include "base/error.h"
#include "base/file.h"

namespace scanmill {

// Thrown if a path leads to something that this program does not make, such as a link. Nothing is changed there. The
// message says what to remove.
class ForeignFile : public InputError {
 public:
  using InputError::InputError;
};

// Throws an Error "PATH: WHAT: REASON", whose REASON is the text of errno after a failed system call.
[[noreturn]] void failBySystem(const std::filesystem::path& path, std::string_view what);

// True if `path`, after links are followed, is `folder` or lies in it. Neither path needs to exist. Throws Error if
// links cannot be followed, such as links in a circle.
bool isWithin(const std::filesystem::path& path, const std::filesystem::path& folder);

// Opens the folder that contains `file` with O_PATH, for openat() and similar calls. `what` is the middle part of the
// Error's message, as in "a.txt: cannot be written: No such file or directory".
Descriptor openFolderOf(const std::filesystem::path& folder, const std::filesystem::path& file, const char* what);

// Creates the folder `below` and any missing folder between `folder` and `below`. Returns true if `below` is new.
bool makeFolders(const std::filesystem::path& folder, const std::filesystem::path& below);

// Moves the file `from` to `to`, and replaces a file that is already at `to`. Creates the folder of `to`.
void moveFile(const std::filesystem::path& folder, const std::filesystem::path& from, const std::filesystem::path& to);

// Removes a file, or a link but not its target. Does nothing if `file` does not exist.
void removeFile(const std::filesystem::path& folder, const std::filesystem::path& file);

}  // namespace scanmill
