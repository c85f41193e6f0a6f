#include "host/io/foam_folder.hpp"

#include <unistd.h>

namespace mortise::io {
namespace {

/// Files of a polyMesh folder that number the cells or faces of another mesh.
constexpr const char* kOfOldMesh[] = {"faceZones",  "pointZones",   "cellLevel",        "pointLevel",
                                      "level0Edge", "surfaceIndex", "refinementHistory"};

std::string without_slashes(std::string path) {
    while (path.size() > 1 && path.back() == '/') path.pop_back();
    return path;
}

std::string folder_above(const std::string& path) {
    const std::size_t slash = path.find_last_of('/');
    if (slash == std::string::npos) return ".";
    return slash == 0 ? "/" : without_slashes(path.substr(0, slash));
}

}  // namespace

FoamFolder::FoamFolder(const std::string& path)
    : path_(without_slashes(path)),
      case_(folder_above(folder_above(path_))),
      constant_(folder_above(path_)),
      folder_(path_) {}

TemporaryFile& FoamFolder::file(const std::string& name) {
    names_.push_back(name);
    return files_.emplace_back(path_ + "/" + name);
}

void FoamFolder::commit() {
    unlink((path_ + "/" + names_.back()).c_str());
    for (const char* const name : kOfOldMesh) unlink((path_ + "/" + name).c_str());
    for (const std::string& name : names_) unlink((path_ + "/" + name + ".gz").c_str());
    for (TemporaryFile& file : files_) file.commit();
    case_.keep();
    constant_.keep();
    folder_.keep();
}

}  // namespace mortise::io
