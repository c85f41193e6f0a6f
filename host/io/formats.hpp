// Readers and writers, one pair per file format; write_mesh and read_mesh choose by extension.
//
// Writers take a mesh whose indices are in range (write_mesh has checked); readers return such a mesh.
#pragma once

#include "host/io/file_reader.hpp"
#include "host/io/stored_array.hpp"
#include "host/io/temporary_file.hpp"
#include "mortise/io.hpp"
#include "mortise/mesh.hpp"

namespace mortise::io {

inline Packing packing_of(const MeshFileOptions& options) {
    return {options.compress ? Coding::kZlib : Coding::kPlain, options.threads};
}

/// `jacobians`: scaled_jacobians(mesh), or empty: they are computed.
void write_vtu(const Mesh& mesh, const std::vector<float>& jacobians, const MeshFileOptions& options,
               TemporaryFile& file);
Mesh read_vtu(const FileReader& file);

void write_msh(const Mesh& mesh, const MeshFileOptions& options, TemporaryFile& file);
Mesh read_msh(const FileReader& file);

/// Throws Error(kMeshing) if a facet is no face of an element.
void write_inp(const Mesh& mesh, const MeshFileOptions& options, TemporaryFile& file);

/// Throws Error(kUsage) if there is a file of that name which write_stl has not made: it may be a part of the
/// model.
void check_stl_is_own(const std::string& path);

/// The outer boundary alone, as triangles in single precision; of second order curved.
void write_stl(const Mesh& mesh, const MeshFileOptions& options, TemporaryFile& file);

/// Writes a folder; MeshFileOptions::compress is not for it.
void write_foam(const Mesh& mesh, const std::string& path, const MeshFileOptions& options);

/// Throws Error(kUsage) for more elements or faces than programs that number them with 32 bits and a sign
/// (OpenFOAM as it is usually built, CalculiX) can read.
void check_numbers(std::uint64_t count, const std::string& path);

/// Reads Gmsh's text formats 4.1 and 2.2, as other programs write them.
Mesh read_gmsh_text(const FileReader& file);

/// The first thing wrong with a mesh's array lengths, indices or regions; empty if all is in range.
std::string find_range_error(const Mesh& mesh);

}  // namespace mortise::io
