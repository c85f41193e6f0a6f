// The quality of a tetrahedron as one formula for a number and for lanes of numbers.
//
// Comparisons of lanes give lanes, and `mask ? x : y` chooses per lane; so the same text serves both, and
// both give the same bits. Everything is inlined: how lanes are passed depends on the machine's registers.
#pragma once

#include "host/improve/quality.hpp"

// Said of every function that returns lanes, though none is ever called.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace mortise::improve {

template <class Real>
struct Vector {
    Real x, y, z;
};

template <class Real>
[[gnu::always_inline]] inline Vector<Real> operator-(const Vector<Real>& a, const Vector<Real>& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Real>
[[gnu::always_inline]] inline Real dot(const Vector<Real>& a, const Vector<Real>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Real>
[[gnu::always_inline]] inline Vector<Real> cross(const Vector<Real>& a, const Vector<Real>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <class Real>
[[gnu::always_inline]] inline Real least(const Real& a, const Real& b) {
    return b < a ? b : a;
}
template <class Real>
[[gnu::always_inline]] inline Real most(const Real& a, const Real& b) {
    return a < b ? b : a;
}

/// The face opposite a node p, and what a tetrahedron's quality takes from it: (p, b, c, d) is positive if
/// the tetrahedron is.
template <class Real>
struct OppositeFace {
    Vector<Real> b, c, d;
    Vector<Real> normal;  ///< outward, twice the area long
    Real squared_normal;
    Real l_bc, l_bd, l_cd;  ///< squared lengths
};

template <class Real>
[[gnu::always_inline]] inline void set_face(OppositeFace<Real>& face) {
    const Vector<Real> bc = face.c - face.b;
    const Vector<Real> bd = face.d - face.b;
    const Vector<Real> cd = face.d - face.c;
    face.normal = cross(bc, bd);
    face.squared_normal = dot(face.normal, face.normal);
    face.l_bc = dot(bc, bc);
    face.l_bd = dot(bd, bd);
    face.l_cd = dot(cd, cd);
}

/// The square of the sine of an angle between faces, or a multiple of it; obtuse angles count more. `inner`
/// is the product of the outward normals: positive where the angle is obtuse.
template <class Real>
[[gnu::always_inline]] inline Real weigh(const Real& square, const Real& inner) {
    return inner > 0 ? kObtuseWeight * kObtuseWeight * square : square;
}

/// Square of the quality of (p, b, c, d), or -1 if it is not positive.
template <class Real>
[[gnu::always_inline]] inline Real squared_quality(const OppositeFace<Real>& face, const Vector<Real>& p,
                                                   double rounding) {
    const Vector<Real> ab = face.b - p;
    const Vector<Real> ac = face.c - p;
    const Vector<Real> ad = face.d - p;
    // Outward normals of the faces, twice their areas long.
    const Vector<Real> abc = cross(ac, ab);
    const Vector<Real> abd = cross(ab, ad);
    const Vector<Real> acd = cross(ad, ac);
    const Vector<Real>& bcd = face.normal;
    const Real volume = -dot(abc, ad);
    const Real l_ab = dot(ab, ab);
    const Real l_ac = dot(ac, ac);
    const Real l_ad = dot(ad, ad);
    const Real n_abc = dot(abc, abc);
    const Real n_abd = dot(abd, abd);
    const Real n_acd = dot(acd, acd);
    const Real& n_bcd = face.squared_normal;
    const Real span = most(most(l_ab, l_ac), most(l_ad, most(face.l_bc, most(face.l_bd, face.l_cd))));
    // The sine of the angle between two faces is 6 V · (length of their edge) / (product of the normals).
    const Real ac_by_bc = n_acd * n_bcd;
    const Real ab_by_ac = n_abc * n_abd;
    Real worst = weigh(l_ab * ac_by_bc, dot(abc, abd));
    worst = least(worst, weigh(l_ac * (n_abd * n_bcd), dot(abc, acd)));
    worst = least(worst, weigh(l_ad * (n_abc * n_bcd), dot(abd, acd)));
    worst = least(worst, weigh(face.l_bc * (n_abd * n_acd), dot(abc, bcd)));
    worst = least(worst, weigh(face.l_bd * (n_abc * n_acd), dot(abd, bcd)));
    worst = least(worst, weigh(face.l_cd * ab_by_ac, dot(acd, bcd)));
    const Real longest = most(most(l_ab * l_ac * l_ad, l_ab * face.l_bc * face.l_bd),
                              most(l_ac * face.l_bc * face.l_cd, l_ad * face.l_bd * face.l_cd));
    worst = least(worst / (ab_by_ac * ac_by_bc), kJacobianWeight * kJacobianWeight / longest);
    const Real square = volume * volume * worst;
    const Real inverted = volume * 0 - 1;
    return (volume > 0) & (volume > rounding * span) ? square : inverted;
}

}  // namespace mortise::improve
