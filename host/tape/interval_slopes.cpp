#include "host/tape/interval_slopes.hpp"

namespace mortise::tape {
namespace {

const Interval kZero = {0, 0};
const Interval kOne = {1, 1};

Interval negative(Interval a) { return interval_apply(kExprNegate, a, kZero); }
Interval quotient(Interval a, Interval b) { return interval_apply(kExprDivide, a, b); }

/// 1 - a², 1 + a², …
Interval one_and_square(Interval a, bool minus) {
    const Interval square = interval_apply(kExprSquare, a, kZero);
    return interval_apply(minus ? kExprSubtract : kExprAdd, kOne, square);
}

}  // namespace

Interval chain(Interval by, Interval d) {
    if ((d.low == 0 && d.high == 0) || (by.low == 0 && by.high == 0)) return kZero;
    if (is_empty_interval(by) || is_empty_interval(d)) return undefined_interval();
    return interval_apply(kExprMultiply, by, d);
}

void interval_slopes(std::int32_t operation, Interval a, Interval b, Interval f, Interval* by_a,
                     Interval* by_b) {
    *by_a = kOne;
    *by_b = kZero;
    const bool constant = f.low == f.high;
    switch (operation) {
        case kExprNegate: *by_a = {-1, -1}; break;
        case kExprAbs: *by_a = {a.low >= 0 ? 1.0F : -1.0F, a.high <= 0 ? -1.0F : 1.0F}; break;
        case kExprSqrt: *by_a = quotient({0.5F, 0.5F}, f); break;
        case kExprSquare: *by_a = {2 * a.low, 2 * a.high}; break;
        case kExprAdd: *by_b = kOne; break;
        case kExprSubtract: *by_b = {-1, -1}; break;
        case kExprMultiply:
            *by_a = b;
            *by_b = a;
            break;
        case kExprDivide:
            *by_a = quotient(kOne, b);
            *by_b = negative(interval_apply(kExprMultiply, f, *by_a));
            break;
        case kExprSin: *by_a = interval_apply(kExprCos, a, kZero); break;
        case kExprCos: *by_a = negative(interval_apply(kExprSin, a, kZero)); break;
        case kExprExp: *by_a = f; break;
        case kExprLog: *by_a = quotient(kOne, a); break;
        case kExprTan: *by_a = one_and_square(f, false); break;
        case kExprAsin:
            *by_a = quotient(kOne, interval_apply(kExprSqrt, one_and_square(a, true), kZero));
            break;
        case kExprAcos:
            *by_a = quotient({-1, -1}, interval_apply(kExprSqrt, one_and_square(a, true), kZero));
            break;
        case kExprAtan: *by_a = quotient(kOne, one_and_square(a, false)); break;
        case kExprAtan2: {
            const Interval square = interval_apply(kExprAdd, interval_apply(kExprSquare, a, kZero),
                                                   interval_apply(kExprSquare, b, kZero));
            const bool jumps = a.low < 0 && a.high >= 0 && b.low <= 0;
            *by_a = jumps ? undefined_interval() : quotient(b, square);
            *by_b = jumps ? undefined_interval() : negative(quotient(a, square));
            break;
        }
        case kExprMod: {
            const bool is_negative = b.high < 0;
            const Interval size = is_negative ? negative(b) : b;
            const Interval whole = interval_apply(kExprFloor, quotient(a, size), kZero);
            const bool jumps = whole.low != whole.high;
            *by_a = jumps ? undefined_interval() : kOne;
            *by_b = jumps ? undefined_interval() : is_negative ? whole : negative(whole);
            break;
        }
        case kExprAnd:
        case kExprOr: {
            const bool first = operation == kExprOr;
            const bool zero = a.low == 0 && a.high == 0;
            *by_a = holds_zero(a) ? (zero ? kZero : undefined_interval()) : (first ? kOne : kZero);
            *by_b = holds_zero(a) ? (zero ? (first ? kOne : kZero) : undefined_interval())
                                  : (first ? kZero : kOne);
            break;
        }
        case kExprHypot:
            *by_a = quotient(a, f);
            *by_b = quotient(b, f);
            break;
        case kExprPower:
            *by_a = interval_apply(kExprMultiply, b, quotient(f, a));
            *by_b = interval_apply(kExprMultiply, f, interval_apply(kExprLog, a, kZero));
            break;
        default: *by_a = *by_b = constant ? kZero : undefined_interval(); break;  // steps
    }
}

Interval slope_of_extremum(std::int32_t operation, Interval a, Interval b, Interval da, Interval db) {
    if (operation == kExprMin ? a.high < b.low : a.low > b.high) return da;
    if (operation == kExprMin ? b.high < a.low : b.low > a.high) return db;
    Interval both = interval_hull(da, db);
    both.partial = da.partial | db.partial;
    return both;
}

}  // namespace mortise::tape
