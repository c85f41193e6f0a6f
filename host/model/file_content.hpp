// Whole files in memory.
#pragma once

#include <string>

namespace mortise::model_reader {

/// Throws Error(kFiles) that names the path and the cause.
std::string read_file(const std::string& path);

/// The extension in lower case, without its dot.
std::string format_of(const std::string& path);
/// The same of an extension, with or without its dot.
std::string format_named(std::string extension);

}  // namespace mortise::model_reader
