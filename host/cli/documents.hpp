// What `mortise` reports about meshes as JSON. Names are append-only.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "host/cli/figures.hpp"
#include "mortise/check.hpp"
#include "mortise/mesher.hpp"

namespace mortise::cli {

using Json = nlohmann::ordered_json;

Json mesh_document(const MeshReport& report, const MeshFigures& figures);
Json check_document(const CheckReport& report);

/// Indented, with a line break at the end; bytes that are not UTF-8 are replaced.
std::string to_text(const Json& document);
/// The same in one line, without its break.
std::string to_line(const Json& document);

}  // namespace mortise::cli
