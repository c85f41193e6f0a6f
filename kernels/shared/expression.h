// General expressions: a register program over doubles, with first derivatives by dual numbers.
//
// Registers are allocated by the compiler; a program leaves its result in register 0. Elementary functions
// are those of elementary.h, the same bits on every device.
#ifndef MORTISE_SHARED_EXPRESSION_H
#define MORTISE_SHARED_EXPRESSION_H

#include "elementary.h"
#include "platform.h"

// Operations. Append-only.
#define kExprConstant 0
#define kExprX 1
#define kExprY 2
#define kExprZ 3
#define kExprNegate 4
#define kExprAbs 5
#define kExprSqrt 6
#define kExprSquare 7
#define kExprAdd 8
#define kExprSubtract 9
#define kExprMultiply 10
#define kExprDivide 11
#define kExprMin 12
#define kExprMax 13
#define kExprSin 14
#define kExprCos 15
#define kExprExp 16
#define kExprLog 17
#define kExprTan 18  // jumps at its poles
#define kExprAsin 19
#define kExprAcos 20
#define kExprAtan 21
#define kExprFloor 22  // jumps at integers, as do ceil and round (halves away from zero)
#define kExprCeil 23
#define kExprRound 24
#define kExprSign 25     // -1, 0, 1
#define kExprNot 26      // a == 0 ? 1 : 0
#define kExprAtan2 27    // angle of (x = b, y = a) in (-π, π]: jumps where y = 0 and x < 0
#define kExprMod 28      // in [0, |b|): jumps at multiples of b
#define kExprCompare 29  // sign of a - b
#define kExprAnd 30      // a == 0 ? 0 : b, whatever b is where a == 0
#define kExprOr 31       // a == 0 ? b : a
#define kExprHypot 32    // sqrt(a² + b²)
#define kExprPower 33
#define kExprOperations 34

#define kExpressionRegisters 64
#define kExpressionLiteral kExpressionRegisters  // as argument: the operation's own literal

typedef struct ExpressionOp {
    i32 operation;
    u32 out;
    u32 a;
    u32 b;
    double literal;
} ExpressionOp;

MORTISE_FUNCTION int expression_is_leaf(i32 operation) { return operation <= kExprZ; }
MORTISE_FUNCTION int expression_is_binary(i32 operation) {
    return (operation >= kExprAdd && operation <= kExprMax) || operation >= kExprAtan2;
}

MORTISE_FUNCTION double expression_compare(double a, double b) {
    if (a != a || b != b) return kMortiseNan;
    return a < b ? -1 : (a > b ? 1 : 0);
}

// Result of one operation. NaN arguments give NaN through every operation, min and max too; only the argument
// that `and` and `or` do not take may be NaN.
MORTISE_FUNCTION double expression_apply(i32 operation, double a, double b) {
    switch (operation) {
        case kExprNegate: return -a;
        case kExprAbs: return mortise_fabs(a);
        case kExprSqrt: return a >= 0 ? mortise_sqrt(a) : kMortiseNan;
        case kExprSquare: return a * a;
        case kExprAdd: return a + b;
        case kExprSubtract: return a - b;
        case kExprMultiply: return a * b;
        case kExprDivide: return a / b;
        case kExprMin: return (a != a || a < b) ? a : b;
        case kExprMax: return (a != a || a > b) ? a : b;
        case kExprSin: return expression_sin(a, 0);
        case kExprCos: return expression_sin(a, 1);
        case kExprExp: return expression_exp(a);
        case kExprLog: return expression_log(a);
        case kExprTan: return expression_tan(a);
        case kExprAsin: return expression_asin(a);
        case kExprAcos: return expression_acos(a);
        case kExprAtan: return expression_atan(a);
        case kExprFloor: return mortise_floor(a);
        case kExprCeil: return -mortise_floor(-a);
        case kExprRound: return expression_round(a);
        case kExprSign: return expression_compare(a, 0);
        case kExprNot: return a != a ? a : (a == 0 ? 1 : 0);
        case kExprAtan2: return expression_atan2(a, b);
        case kExprMod: return expression_mod(a, b);
        case kExprCompare: return expression_compare(a, b);
        case kExprAnd: return a == 0 || a != a ? a : b;
        case kExprOr: return a == 0 ? b : a;
        case kExprHypot: return expression_hypot(a, b);
        default: return expression_power(a, b);
    }
}

MORTISE_NOINLINE double expression_value(MORTISE_GLOBAL ExpressionOp* ops, u32 count, const double* u) {
    double r[kExpressionRegisters + 1];
    r[0] = 0;
    for (u32 i = 0; i < count; ++i) {
        const i32 operation = ops[i].operation;
        if (operation == kExprConstant) {
            r[ops[i].out] = ops[i].literal;
        } else if (operation <= kExprZ) {
            r[ops[i].out] = u[operation - kExprX];
        } else {
            r[kExpressionLiteral] = ops[i].literal;
            r[ops[i].out] = expression_apply(operation, r[ops[i].a], r[ops[i].b]);
        }
    }
    return r[0];
}

// Derivatives of one operation by its arguments, `value` being its result. 0 where a function only jumps.
MORTISE_FUNCTION void expression_slopes(i32 operation, double a, double b, double value, double* by_a,
                                        double* by_b) {
    *by_a = 0;
    *by_b = 0;
    switch (operation) {
        case kExprNegate: *by_a = -1; break;
        case kExprAbs: *by_a = a < 0 ? -1 : 1; break;
        case kExprSqrt: *by_a = value > 0 ? 0.5 / value : 0; break;
        case kExprSquare: *by_a = 2 * a; break;
        case kExprAdd:
            *by_a = 1;
            *by_b = 1;
            break;
        case kExprSubtract:
            *by_a = 1;
            *by_b = -1;
            break;
        case kExprMultiply:
            *by_a = b;
            *by_b = a;
            break;
        case kExprDivide:
            *by_a = 1 / b;
            *by_b = -value / b;
            break;
        case kExprMin:
            *by_a = a < b ? 1 : 0;
            *by_b = 1 - *by_a;
            break;
        case kExprMax:
            *by_a = a > b ? 1 : 0;
            *by_b = 1 - *by_a;
            break;
        case kExprSin: *by_a = expression_sin(a, 1); break;
        case kExprCos: *by_a = -expression_sin(a, 0); break;
        case kExprExp: *by_a = value; break;
        case kExprLog: *by_a = 1 / a; break;
        case kExprTan: *by_a = 1 + value * value; break;
        case kExprAsin: *by_a = 1 / mortise_sqrt((1 - a) * (1 + a)); break;
        case kExprAcos: *by_a = -1 / mortise_sqrt((1 - a) * (1 + a)); break;
        case kExprAtan: *by_a = 1 / (1 + a * a); break;
        case kExprAtan2: {
            const double square = a * a + b * b;
            *by_a = square > 0 ? b / square : 0;
            *by_b = square > 0 ? -a / square : 0;
            break;
        }
        case kExprMod:
            *by_a = 1;
            *by_b = b < 0 ? mortise_floor(a / -b) : -mortise_floor(a / b);
            break;
        case kExprAnd: *by_b = a == 0 ? 0 : 1; break;
        case kExprOr:
            *by_a = a == 0 ? 0 : 1;
            *by_b = 1 - *by_a;
            break;
        case kExprHypot:
            *by_a = value > 0 ? a / value : 0;
            *by_b = value > 0 ? b / value : 0;
            break;
        case kExprPower:
            *by_a = a != 0 ? b * (value / a) : (b == 1 ? 1 : 0);
            *by_b = a > 0 ? value * expression_log(a) : 0;
            break;
        default: break;
    }
}

// Value, and gradient with respect to u, by forward differentiation.
MORTISE_NOINLINE double expression_sample(MORTISE_GLOBAL ExpressionOp* ops, u32 count, const double* u,
                                          double* gradient) {
    double r[kExpressionRegisters + 1];
    double d[kExpressionRegisters + 1][3];
    r[0] = 0;
    for (int j = 0; j < 3; ++j) d[0][j] = d[kExpressionLiteral][j] = 0;
    for (u32 i = 0; i < count; ++i) {
        const i32 operation = ops[i].operation;
        const u32 out = ops[i].out;
        if (operation <= kExprZ) {
            r[out] = operation == kExprConstant ? ops[i].literal : u[operation - kExprX];
            for (int j = 0; j < 3; ++j) d[out][j] = (operation == kExprX + j) ? 1 : 0;
            continue;
        }
        r[kExpressionLiteral] = ops[i].literal;
        const double a = r[ops[i].a];
        const double b = r[ops[i].b];
        const double value = expression_apply(operation, a, b);
        double by_a;
        double by_b;
        expression_slopes(operation, a, b, value, &by_a, &by_b);
        for (int j = 0; j < 3; ++j) {
            const double da = d[ops[i].a][j];
            const double db = d[ops[i].b][j];
            // What is not taken may have an infinite slope, and infinite slopes may be at what stays as
            // it is: acos(min(f, 1)).
            d[out][j] = (by_a != 0 && da != 0 ? by_a * da : 0) + (by_b != 0 && db != 0 ? by_b * db : 0);
        }
        r[out] = value;
    }
    for (int j = 0; j < 3; ++j) gradient[j] = d[0][j];
    return r[0];
}

#endif
