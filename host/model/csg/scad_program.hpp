// OpenSCAD's .scad files, by the installed program `openscad`, which writes them as .csg.
#pragma once

#include <string>
#include <vector>

#include "mortise/model.hpp"

namespace mortise::model_reader {

struct ConvertedScad {
    std::string csg;                    ///< paths in it are relative to the folder of the .scad file
    std::vector<std::string> warnings;  ///< OpenSCAD's, with file and line
};

/// `text` is what the file holds. Throws Error(kInput) with OpenSCAD's first error, or what to do without it.
ConvertedScad convert_scad(const std::string& path, const std::string& text, const ReadOptions& options);

/// Throws Error(kUsage) unless all definitions are NAME=VALUE.
void check_definitions(const std::vector<std::string>& definitions);

}  // namespace mortise::model_reader
