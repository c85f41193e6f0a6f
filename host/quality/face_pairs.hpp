// Whether the faces of a mesh fit together, cheaply enough for every run.
#pragma once

#include <cstdint>

#include "mortise/mesh.hpp"

namespace mortise::quality {

/// A sum of hashes of faces, modulo 2^32 twice.
struct FaceSum {
    std::uint32_t low = 0, high = 0;

    FaceSum& operator+=(const FaceSum& other) {
        low += other.low;
        high += other.high;
        return *this;
    }
    FaceSum& operator-=(const FaceSum& other) {
        low -= other.low;
        high -= other.high;
        return *this;
    }
    friend FaceSum operator+(FaceSum a, const FaceSum& b) { return a += b; }
    friend FaceSum operator-(FaceSum a, const FaceSum& b) { return a -= b; }
    friend bool operator==(const FaceSum& a, const FaceSum& b) { return a.low == b.low && a.high == b.high; }
    friend bool operator!=(const FaceSum& a, const FaceSum& b) { return !(a == b); }
};

/// Sum of hashes of all faces of the mesh's elements, each negative the other way round: faces in opposite
/// pairs cancel. Parts of a mesh, with its node numbers, add up. One pass and no memory.
FaceSum sum_of_faces(const Mesh& mesh, int threads);

/// The same of the outer boundary's facets: equal to that of the elements if the mesh is conforming and lists
/// them all, outside in front. A mesh of which that is not so passes by chance once in 2^60 times or less;
/// check_mesh tells what does not fit.
FaceSum sum_of_outer_facets(const FacetBlock& facets, int threads);

/// The same of faces with hanging nodes: what a larger face and the four that it meets leave of the sum.
/// Throws what hanging_faces throws.
FaceSum sum_of_hanging_faces(const HangingNodes& hanging);

inline bool faces_are_paired(const Mesh& mesh, int threads) {
    return sum_of_faces(mesh, threads) ==
           sum_of_outer_facets(mesh.facets, threads) + sum_of_hanging_faces(mesh.hanging);
}

}  // namespace mortise::quality
