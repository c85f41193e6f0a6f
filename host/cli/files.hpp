// Output files of the command line.
#pragma once

#include <string>
#include <vector>

#include "mortise/io.hpp"
#include "mortise/mesher.hpp"

namespace mortise::cli {

/// What of a mesh made so not every format can hold, as far as options tell: hexahedra have pyramids beside
/// them at nearly every boundary.
MeshTraits traits_of(const MeshOptions& options);

/// Throws what writing a mesh of that name would throw, as far as that can be known before the work starts.
void check_mesh_output(const std::string& path);
/// The same for all of them, and what their formats cannot hold of a mesh made so.
void check_mesh_outputs(const std::vector<std::string>& paths, const MeshOptions& options);

/// The same for a file that must end in `extension`, such as ".png"; `option` names it in messages.
void check_other_output(const std::string& option, const std::string& path, const std::string& extension);

/// Whether two names lead to one file, whether it is there yet or not.
bool is_same_file(const std::string& first, const std::string& second);

/// Writes the whole file or, with Error(kFiles), none of it.
void write_text(const std::string& path, const std::string& text);

/// Prints on stdout; Error(kFiles) if that fails.
void print(const std::string& text);

}  // namespace mortise::cli
