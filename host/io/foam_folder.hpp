// OpenFOAM's polyMesh folder, changed as a whole or not at all.
#pragma once

#include <deque>
#include <string>

#include "host/io/temporary_file.hpp"

namespace mortise::io {

/// Folders above polyMesh that are made, too: those of a case, as case/constant.
inline constexpr int kMostCaseFolders = 2;

/// Files under temporary names in a folder that is made if it is missing, and its case with it; without
/// commit() nothing of it is left. Failures as those of TemporaryFile.
class FoamFolder {
  public:
    explicit FoamFolder(const std::string& path);

    /// A new file of that name; the last one named is what a mesh is not read without.
    TemporaryFile& file(const std::string& name);

    /// Gives all files their names, the last one last, and removes what belongs to the mesh that was there
    /// before: an interruption in between leaves a folder that OpenFOAM refuses.
    void commit();

  private:
    std::string path_;
    NewFolder case_, constant_, folder_;
    std::deque<std::string> names_;
    std::deque<TemporaryFile> files_;  ///< goes before the folder
};

}  // namespace mortise::io
