// What a run has found out about a model: warnings, or errors where MeshOptions::strict is set.
#pragma once

#include <string>
#include <vector>

#include "host/features/hinges.hpp"
#include "host/improve/improve.hpp"
#include "host/pipeline/prepare.hpp"
#include "host/probe/overlaps.hpp"
#include "mortise/mesher.hpp"

namespace mortise::pipeline {

/// A warning; Error(kMeshing) if MeshOptions::strict is set.
void warn_or_refuse(const std::string& text, const MeshOptions& options, const std::string& source,
                    MeshReport& out);

/// Error(kInput) if a formula is 0 throughout a leaf (Probe::flat).
void refuse_flat(const std::optional<std::uint64_t>& flat, const Prepared& prepared,
                 const std::string& source);

/// Error(kMeshing) if any of these is lost that is longer than two cells: of shorter ones the mesh may tell
/// more (report_small_pieces).
void refuse_surely_missed(const std::vector<MissedFeature>& missed, const Root& root, int refine,
                          const std::string& source);

/// Error(kMeshing) if any of these is lost.
void refuse_missed(const std::vector<MissedFeature>& missed, const Root& root, int refine,
                   const std::string& source);

/// A line for each pair of regions that overlap; behind the first few, one for all others.
void report_overlaps(const std::vector<probe::Overlap>& overlaps, const Model& model,
                     const MeshOptions& options, MeshReport& out);

/// Throws Error(kMeshing) if something was left out and MeshOptions::strict is set.
void report_improvement(const improve::Counters& counters, const MeshOptions& options,
                        const std::string& source, MeshReport& out);

/// Warns where the skin of the mesh touches itself. Throws Error(kMeshing) if MeshOptions::strict
/// is set. `points` of the nodes that the hinges number.
void report_hinges(const features::Hinges& hinges, const std::vector<double>& points,
                   const MeshOptions& options, const std::string& source, MeshReport& out);

/// Warns of small pieces and hollows that are more in the model (probe/loose_pieces.hpp); Error(kMeshing) if
/// MeshOptions::strict is set. Missed features that the mesh has as pieces of their own are kept.
void report_small_pieces(const Prepared& prepared, const std::vector<double>& points,
                         const FacetBlock& facets, const MeshOptions& options, const std::string& source,
                         MeshReport& out);

/// Adds to MeshReport::missed what the finished mesh closes or tears where surfaces fold within a cell
/// (probe/false_facets.hpp). Throws Error(kMeshing) if MeshOptions::strict is set and there is any.
void report_false_facets(const Prepared& prepared, const std::vector<double>& points,
                         const FacetBlock& facets, const MeshOptions& options, const std::string& source,
                         MeshReport& out);

/// What the report tells of leaves and lost features. Throws Error(kMeshing) if the options forbid these.
void report_cells(const Prepared& prepared, const Extracted& extracted, const Model& model,
                  const MeshOptions& options, MeshReport& out);

/// Warns where walls have fewer or lower layers than asked.
void report_layers(const std::string& source, MeshReport& out);

/// Where a region has no element, by region: named in the file, but not in the mesh.
void warn_of_empty_regions(const std::vector<std::string>& names, const std::vector<bool>& present,
                           const std::string& source, MeshReport& report);

/// Error(kInput): a model without elements.
[[noreturn]] void refuse_empty(const std::string& source);
/// Of a mesh whose faces do not fit together.
[[noreturn]] void refuse_unpaired(const std::string& source);

}  // namespace mortise::pipeline
