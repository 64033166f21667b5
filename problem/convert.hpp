#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace modsearch {

/// What a file can be converted to.
enum class FileFormat {
  kModsearch,  ///< ours, supersets of Timor's and CoBRA's
  kTimor,      ///< a module library without parameters
  kCobra,      ///< a task, or a solution
  kUrdf,       ///< the arm of a design
};
/// "modsearch", "timor", "cobra", "urdf".
[[nodiscard]] std::string_view name(FileFormat format);
[[nodiscard]] std::optional<FileFormat> file_format_from_name(std::string_view name);

struct ConvertOptions {
  FileFormat to = FileFormat::kModsearch;
  /// Library, as a file or ID, of a design that names none, or instead of the one it names.
  std::optional<std::string> library{};
  std::filesystem::path folder = ".";  ///< the text will lie here: what it refers to is named relative to it
  std::optional<std::filesystem::path> mesh_root{};  ///< where meshes are looked for first (FileOptions)
};

/// `file`, or a built-in library or problem by its ID, as text of another format. What it is is seen from its content:
///
/// | it is                                        | modsearch | timor           | cobra        | urdf |
/// |----------------------------------------------|-----------|-----------------|--------------|------|
/// | library                                      | itself    | itself          |              |      |
/// | task                                         | itself    |                 | itself       |      |
/// | problem                                      | itself    | its library     | its task     |      |
/// | solution (one of CoBRA's own is a design)    | itself    | its modules     | itself       | arm  |
/// | design: a list, or an assembly (moduleOrder) | list      | its modules     | assembly     | arm  |
///
/// The modules of a design are those of `frozen`, lengths fixed. Files that are referred to stay where they are; no
/// mesh is opened for a library or a task. What Timor and CoBRA ask for and ours need not have is filled in
/// (docs/formats.md). Throws FileError, one sentence, for what cannot be read or cannot be said in
/// that format.
[[nodiscard]] std::string convert(const std::string& file, const ConvertOptions& options);

}  // namespace modsearch
