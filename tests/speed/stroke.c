/* G82 with the package's own process, written by hand: the speed reference of the compiled loops, with equal bits.
 *
 * Stroke, exp and log, rules of the cycle and tally are those of process/stroke.py, kernel/exp_log.py,
 * control/cycles/plunge.py and machine/loops/stroke_totals.py, term by term. LANES machines run side by side; when the
 * cycle of one ends, the next machine takes its lane. c_reference.py writes records.h, which lists the fields of
 * the named tuples, and sets LANES.
 */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "records.h"

#define ROW(field) double field;
#define LANE(field) double field[LANES];
#define GET(field) value.field = from->field[lane];
#define PUT(field) to->field[lane] = value.field;
#define RECORD(name) \
    typedef struct { name##_FIELDS(ROW) } name; \
    typedef struct { name##_FIELDS(LANE) } name##Lanes; \
    static inline name get_##name(const name##Lanes *from, int lane) { \
        name value; \
        name##_FIELDS(GET) \
        return value; \
    } \
    static inline void put_##name(name##Lanes *to, int lane, name value) { name##_FIELDS(PUT) }
RECORD(Cycle)
RECORD(Parameters)
RECORD(Constants)
RECORD(Wheel)
RECORD(Part)
RECORD(Progress)
RECORD(Tally)

typedef struct {
    CycleLanes cycle;
    ConstantsLanes slow;
    ConstantsLanes held;
    WheelLanes wheel;
    PartLanes part;
    ProgressLanes progress;
    TallyLanes tally;
    double event[LANES];
} Lanes;

#define INLINE static inline __attribute__((always_inline))
#define PI 3.141592653589793
#define NEARLY_NOTHING 1e-300
#define DEPTH_TOLERANCE 1e-9

INLINE double least(double a, double b) { return b < a ? b : a; }
INLINE double most(double a, double b) { return b > a ? b : a; }
INLINE int64_t bits_of(double x) { int64_t bits; memcpy(&bits, &x, sizeof bits); return bits; }
INLINE double float_of(int64_t bits) { double x; memcpy(&x, &bits, sizeof x); return x; }

#define LN2_HIGH 6.93147180369123816490e-01
#define LN2_LOW 1.90821492927058770002e-10
#define ROUND 6755399441055744.0
#define ROUND_BITS 0x4338000000000000LL
#define SQRT_HALF_BITS 0x3FE6A09E667F3BCDLL

INLINE double exp_(double x) {
    x = least(most(x, -700.0), 700.0);
    double shifted = x * (1.0 / 0.6931471805599453) + ROUND, k = shifted - ROUND;
    double r = (x - k * LN2_HIGH) - k * LN2_LOW, r2 = r * r, r4 = r2 * r2;
    double low = (1.0 + r) + r2 * (0.5 + r * 0.16666666666666669);
    double middle = (0.041666666666624164 + r * 0.008333333333330065)
        + r2 * (0.00138888889171967 + r * 0.00019841269863040545);
    double high = (2.4801521322368692e-05 + r * 2.7557268480310024e-06)
        + r2 * (2.7620075879983367e-07 + r * 2.5100375832561234e-08);
    return ((low + r4 * middle) + (r4 * r4) * high) * float_of((bits_of(shifted) - ROUND_BITS + 1023) << 52);
}

INLINE double log_(double x) {
    int64_t bits = bits_of(x);
    /* arithmetic shift by 52 with instructions of AVX2 */
    int64_t exponent = (int64_t)(((uint64_t)(bits - SQRT_HALF_BITS) + (1ULL << 63)) >> 52) - 2048;
    double m = float_of(bits - (int64_t)((uint64_t)exponent << 52)), k = float_of(ROUND_BITS + exponent) - ROUND;
    double f = m - 1.0, s = f / (2.0 + f), z = s * s, z2 = z * z;
    double low = (0.666666666666667 + z * 0.39999999999899505) + z2 * (0.28571428625975487 + z * 0.2222221113479508);
    double high = (0.18182889125261723 + z * 0.15331721600556042) + z2 * 0.14616449685043406;
    double series = z * (low + (z2 * z2) * high);
    return k * LN2_HIGH + (f - (s * (f - series) - k * LN2_LOW));
}

INLINE double whole_ms(double seconds) { return floor(1000.0 * seconds + (0.5 + 1e-6)) / 1000.0; }
INLINE double cooled(double dT, double seconds, double rate) { return dT * exp_(-seconds * rate); }
INLINE double wheel_speed(double ds, double n, double vs_set) { return vs_set > 0.0 ? vs_set : 0.001 * PI * n * ds; }
INLINE double worn_diameter(double ds, double radial) { return most(ds - 2.0 * radial, least(ds, 20.0)); }
INLINE double chip_force(double Q, double per_vs, double u_ch) { return u_ch * Q * per_vs; }
INLINE double log_chip_wear(double heq, double mG) { return mG * log_(most(heq, 0.001) * (1.0 / 0.1)); }

static Constants constants_of(const Parameters *p, double vw, double Lw) {
    Constants k;
    k.n = p->n, k.vs_set = p->vs_set, k.vw = vw, k.Lw = Lw;
    k.pa = p->pm * p->pa, k.pb = p->pm * p->pb * (0.004 * vw);
    k.AL = p->AL, k.kp = p->kp, k.mu = p->mu, k.kc = p->kc, k.u_ch = p->u_ch;
    k.sa = sqrt(p->a0), k.per_ke = 1.0 / p->ke;
    k.Cref = p->Cref, k.per_Cref = 1.0 / p->Cref, k.per_Vr = 1.0 / p->Vr;
    k.power = p->power, k.rs = p->rs, k.stall = p->rs / p->power, k.stall_time = p->stall_time;
    k.flattening = 8.0 * p->Rr * p->Rr / (PI * p->E_star);
    k.krw = p->krw, k.beta = p->beta, k.peclet = vw / (4.0 * p->alpha), k.e_ch = p->e_ch;
    k.hf = sqrt(2.4 / 30.0) * p->hf, k.kfilm = p->kfilm, k.Tb = p->Tb, k.u0 = p->u0, k.Bm = p->Bm;
    k.per_G = 1.0 / p->Gref, k.mG = p->mG, k.per_fc = 1.0 / p->fc, k.kf = p->kf;
    k.wi = p->wi, k.per_Vi = 1.0 / p->Vi, k.per_dr = 1.0 / p->dr, k.turned = 1000.0 * Lw / (PI * vw);
    k.kA = p->kA, k.kL = p->kL, k.Af = p->Af, k.Amax = p->Amax, k.per_Amax = 1.0 / p->Amax;
    k.RaRef = p->RaRef, k.f0 = p->f0, k.f1 = p->f1, k.log_gm = log_(p->gm), k.nr = p->nr;
    k.least_chips = log_chip_wear(0.02, p->mG), k.ra_scale = p->ra_scale, k.per_vw = 1.0 / vw;
    k.per_capacity = p->per_capacity, k.swell = p->swell;
    k.w_1 = p->w_1, k.w_2 = p->w_2, k.w_3 = p->w_3, k.w_4 = p->w_4;
    k.r_1 = p->r_1, k.r_2 = p->r_2, k.r_3 = p->r_3, k.r_4 = p->r_4;
    return k;
}

/* Compute a stroke at one wheel speed, and the wheel after it. */
typedef struct { double ae, load, torque, T, Br, worn, Ra, ds, A, lam, V, W, dT_1, dT_2, dT_3, dT_4; } Node;

INLINE Node node_of(const ConstantsLanes *held, int l, double b, double face, double own_seconds, double S, double Rs,
                    double ds, double A, double lam, double V, double Rd, double Cd, double W, double dT_1,
                    double dT_2, double dT_3, double dT_4) {
#define K(field) held->field[l]
    /* depth of cut and forces */
    double speed = wheel_speed(ds, K(n), K(vs_set)), per_speed = 1.0 / (ds * speed), per_ds = per_speed * speed;
    double sd = sqrt(ds), u = face - W - S, fresh = exp_(-V * K(per_Vr)), settled = 1.1 * K(Cref);
    double density = settled + (Cd - settled) * fresh;
    double Kp = K(kp) * sqrt(density * K(per_Cref)) * (1.0 + 0.5 * lam);
    double flats = (K(pa) + K(pb) * per_speed) * (A + K(AL) * lam);
    double Kt = Kp + K(mu) * flats, Kn = K(kc) * Kp + flats, per_speed_set = per_speed * ds;
    double give = b * K(per_ke), F0 = Kn * sd * K(sa), chip = chip_force(K(vw), per_speed_set, K(u_ch));
    double beyond = most(u - give * F0, 0.0), g1 = 1.0 + give * K(kc) * chip;
    double half = give * Kn * sd + 2.0 * g1 * K(sa);
    double x = 2.0 * beyond / (half + sqrt(half * half + 4.0 * g1 * beyond) + NEARLY_NOTHING);
    double ae = x * (x + 2.0 * K(sa));
    double share = least(most(u / most(give * F0, NEARLY_NOTHING), 0.0), 1.0);
    double rubbing = sd * (x + share * K(sa)), Q = ae * K(vw);

    /* available torque of the spindle */
    double has = most(K(power) - b * K(u_ch) * Q, 1e-6), asks = most(b * Kt * rubbing * speed, 1e-6);
    double per = 1.0 / (has * asks);
    double kept = least(most(has * has * per, K(rs)), 1.0), over = least(most(asks * asks * per, 1.0), 1.0 / K(rs));
    double vs = speed * kept, per_vs = per_speed_set * over, Ft_c = chip_force(Q, per_vs, K(u_ch));
    double Ft = Ft_c + Kt * rubbing, Fn = K(kc) * Ft_c + Kn * rubbing, P = Ft * vs, load = b * Ft * speed;
    double heq = Q * per_vs, lc = sd * sqrt(ae + K(flattening) * Fn), fg = Fn / (density * most(lc, 1e-7));
    double torque = load * K(stall);

    /* heat */
    double L = K(peclet) * lc, jaeger = 1.16 / (1.0 + 0.29 / (sqrt(L * sqrt(L)) + 1e-12));
    double grains = (1.0 + 20.8 * A) * vs, per_grains = 1.0 / (jaeger * grains);
    double work = K(beta) * sqrt(K(vw) * lc * grains * per_grains), sink = K(krw) * sqrt(jaeger * per_grains);
    double film = K(hf) * sqrt(vs * lc) * (1.0 - 0.5 * lam), heat = P - least(K(e_ch) * Q, 0.45 * P);
    double both = work * (1.0 + sink), by_wet = both + film + 1e-150, by_dry = both + K(kfilm) * film + 1e-150;
    double per_both = 1e6 * heat / (by_wet * by_dry), wet = per_both * by_dry, dry = per_both * by_wet;
    double y = least(most((wet - K(Tb)) * (1.0 / 20.0) + 0.5, 0.0), 1.0);
    double T = wet + (dry - wet) * (y * y * (3.0 - 2.0 * y)), flow = 1e-6 * T * work;
    double burns = K(u0) * Q + 0.88 * K(Bm) * (1.0 + sink) * sqrt(rubbing * K(vw));
    double Br = burns > 0.0 ? P / burns : 0.0;

    /* wear */
    double dV = ae * K(Lw), z = fg * K(per_fc) - 1.0, breaking = 1.0 + 0.5 * K(kf) * (z + sqrt(z * z + 0.1));
    double chips = log_chip_wear(heq, K(mG));
    double steady = dV * breaking * exp_(chips) * K(per_G) * per_ds * (1.0 / PI);
    double renewal = least(steady * K(per_dr), 1.0), thinned = K(Cref) / Cd;
    double loss = K(wi) * (thinned * thinned) * (thinned * thinned);
    double before = 1.0 + V * K(per_Vi), more = dV * K(per_Vi), after = before + more, square = before * after;
    double dw = steady + loss * more * (before + after) / (square * square);
    double sliding = K(turned) * vs * per_ds * rubbing;
    double hotter = exp_(least(most(0.002 * (T - 200.0), -1.0), 2.0));
    double growth = K(kA) * sliding * hotter * (1.0 - A * K(per_Amax)), worn = PI * ds * dw * b;

    /* roughness */
    double Rt = 0.9 * K(RaRef) + (Rd - 0.9 * K(RaRef)) * fresh, broken = 0.5 * (breaking - 1.0);
    double roughened = exp_(K(nr) * (most(chips, K(least_chips)) - K(log_gm))) * (1.0 + broken + K(nr) * broken)
        / (1.0 + broken - K(nr) * broken);
    double Rg = K(ra_scale) * roughened * Rt * sqrt(30.0 * per_vs) * (K(f0) + K(f1) * sqrt(Q * (1.0 / 3.0)))
        * (1.0 + 0.6 * lam);
    double reach = 1000.0 * ae + least(most(1000.0 * u, 0.0), 0.5);
    double Ra = Rs + (Rg - Rs) * (reach / (reach + 2.0 * Rs + NEARLY_NOTHING));

    double warmer = b * flow * K(per_vw) * K(per_capacity), later = whole_ms(own_seconds);
#define MODE(n) .dT_##n = cooled(dT_##n + K(w_##n) * warmer, later, K(r_##n))
    return (Node){
        .ae = ae, .load = load, .torque = torque, .T = T, .Br = Br, .worn = worn, .Ra = Ra,
        .ds = worn_diameter(ds, dw),
        .A = least(most(A + growth - (A - K(Af)) * renewal, 0.0), K(Amax)),
        .lam = least(lam + K(kL) * dV * (1.0 - lam), 1.0) - lam * renewal,
        .V = V + dV,
        .W = W + dw,
        MODE(1), MODE(2), MODE(3), MODE(4),
    };
#undef MODE
#undef K
}

/* Compute one stroke in every lane, and the pick at the reversal after it. */
static __attribute__((noinline)) void advance(Lanes *restrict rows) {
#pragma GCC ivdep
    for (int l = 0; l < LANES; l++) {
#define C(field) rows->cycle.field[l]
#define K(field) rows->held.field[l]
#define MIX(field) (fast.field + share * (slow.field - fast.field))
        double ds = rows->wheel.ds[l], A = rows->wheel.A[l], lam = rows->wheel.lam[l], V = rows->wheel.V[l];
        double Rd = rows->wheel.Rd[l], Cd = rows->wheel.Cd[l], W = rows->wheel.W[l];
        double dT_1 = rows->wheel.dT_1[l], dT_2 = rows->wheel.dT_2[l];
        double dT_3 = rows->wheel.dT_3[l], dT_4 = rows->wheel.dT_4[l];
        double deepest = rows->part.Z[l], S = rows->part.S[l], Rs = rows->part.Rs[l];
        double reversal = rows->progress.reversal[l], depth = rows->progress.depth[l];
        double peak_torque = rows->tally.peak_torque[l];

        /* position and time */
        double Z = depth >= C(depth) ? C(bottom) : (C(start) + depth) + C(surface);
        double seconds = reversal > 0.0 ? C(stroke_seconds) : C(first_seconds);
        double own_seconds = reversal > 0.0 ? C(stroke_seconds) : C(set_out);
        double face = (peak_torque >= 1.0 ? -1000.0 : Z) + K(swell) * (dT_1 + dT_2 + dT_3 + dT_4), b = C(width);
        double share = C(slow_share), fast_S = S + share * rows->part.S_step[l], slow_S = fast_S - rows->part.S_step[l];
        double fast_Rs = Rs + share * rows->part.Rs_step[l], slow_Rs = fast_Rs - rows->part.Rs_step[l];
        Node slow = node_of(&rows->slow, l, b, face, own_seconds, slow_S, slow_Rs, ds, A, lam, V, Rd, Cd, W,
                            dT_1, dT_2, dT_3, dT_4);
        Node fast = node_of(&rows->held, l, b, face, own_seconds, fast_S, fast_Rs, ds, A, lam, V, Rd, Cd, W,
                            dT_1, dT_2, dT_3, dT_4);
        double load = fast.load + C(slow_time) * (slow.load - fast.load), peak = most(fast.load, slow.load);
        double torque = most(fast.torque, slow.torque), hottest = most(fast.T, slow.T), Br = most(fast.Br, slow.Br);

        rows->wheel.ds[l] = MIX(ds);
        rows->wheel.A[l] = MIX(A);
        rows->wheel.lam[l] = MIX(lam);
        rows->wheel.V[l] = MIX(V);
        rows->wheel.W[l] = MIX(W);
        rows->wheel.dT_1[l] = MIX(dT_1);
        rows->wheel.dT_2[l] = MIX(dT_2);
        rows->wheel.dT_3[l] = MIX(dT_3);
        rows->wheel.dT_4[l] = MIX(dT_4);

        rows->part.Z[l] = most(deepest, Z);
        rows->part.S[l] = S + MIX(ae);
        rows->part.Rs[l] = MIX(Ra);
        rows->part.S_step[l] = rows->part.S_step[l] + (fast.ae - slow.ae);
        rows->part.Rs_step[l] = fast.Ra - slow.Ra;

        /* tally */
#define T(field) rows->tally.field[l]
        int finishing = C(finish) - Z <= 0.05 + DEPTH_TOLERANCE, plunge = deepest + DEPTH_TOLERANCE < Z;
        int grinds = peak_torque < 1.0, full = (C(full_plunge) <= Z - deepest) & grinds;
        int among_first = full & (T(first_count) < 6.0);
        double p1 = T(power_1), p2 = T(power_2), p3 = T(power_3), p4 = T(power_4), p5 = T(power_5), p6 = T(power_6);
        T(power_1) = full ? load : p1, T(power_2) = full ? p1 : p2, T(power_3) = full ? p2 : p3;
        T(power_4) = full ? p3 : p4, T(power_5) = full ? p4 : p5, T(power_6) = full ? p5 : p6;
        T(last_count) = least(T(last_count) + (full ? 1.0 : 0.0), 6.0);
        T(first_power) = T(first_power) + (among_first ? load : 0.0);
        T(first_count) = T(first_count) + (among_first ? 1.0 : 0.0);
        T(seconds) = T(seconds) + seconds + ((torque >= 1.0) & grinds ? K(stall_time) : 0.0);
        T(strokes) = T(strokes) + 1.0;
        T(deepened) = T(deepened) + most(Z - deepest, 0.0);
        T(peak_load) = most(T(peak_load), peak);
        T(peak_torque) = most(peak_torque, torque);
        T(plunge_rise) = most(T(plunge_rise), plunge ? hottest : 0.0);
        T(finish_rise) = most(T(finish_rise), plunge & finishing ? hottest : 0.0);
        T(burn_ratio) = most(T(burn_ratio), plunge ? Br : 0.0);
        T(worn) = T(worn) + MIX(worn);
#undef T

        /* pick, and dresses that are due */
        int at_depth = depth >= C(depth);
        reversal = reversal + 1.0;
        double pick = reversal - 2.0 * floor(0.5 * reversal) == 1.0 ? C(primary_pick) : C(secondary_pick);
        double picked = (pick > 0.0) & (C(depth) - depth <= pick + DEPTH_TOLERANCE) ? C(depth) : depth + pick;
        depth = at_depth ? depth : picked;
        double left = rows->progress.left[l] - (at_depth ? 1.0 : 0.0), total = C(depth) > 0.0 ? C(depth) : 1.0;
        double due = least(C(executions), floor(depth * (C(executions) + 1.0) / total + 1e-9));
        due = C(depth) > 0.0 ? due : 0.0;
        double dresses = due - rows->progress.dressed[l];
        rows->progress.reversal[l] = reversal;
        rows->progress.depth[l] = depth;
        rows->progress.left[l] = left;
        rows->progress.dressed[l] = due;
        rows->progress.dresses[l] = dresses;
        rows->event[l] = ((depth >= C(depth)) & (left <= 0.0)) | (dresses > 0.0) ? 1.0 : 0.0;
#undef C
#undef K
#undef MIX
    }
}

static void dress(const Cycle *c, const Parameters *p, Wheel *w, Tally *t) {
    double passes = c->dress_passes, depth = c->dress_depth;
    double lead = c->dress_feed * PI * w->ds / (1000.0 * wheel_speed(w->ds, p->n, p->vs_set));
    double phi = 1.0 - exp_(-(passes * depth / (p->dd * (1.0 + w->lam + w->A / 0.05)))), keep = 1.0 - phi;
    double blunt = 1.0 + w->wd / p->b0;
    double s = most((depth / 0.020) * sqrt(lead / 0.10) * p->qs / blunt, 0.01);
    double A = least(p->Ad * (0.25 + 0.75 / sqrt(s)), p->Amax), Cd = p->Cref / sqrt(sqrt(s));
    double fine = log_(lead / 0.10), deep = log_(most(depth / 0.020, 0.01));
    double Rd = p->RaRef * p->qr * exp_(p->nf * fine + p->na * deep) * exp_(-p->nw * log_(blunt));
    double removed = passes * depth * PI * w->ds * p->bs, seconds = whole_ms(c->dress_seconds);
    w->ds = worn_diameter(w->ds, passes * depth);
    w->A = A + keep * (w->A - A);
    w->lam = keep * w->lam;
    w->V = keep * w->V;
    w->Rd = phi * Rd + keep * w->Rd;
    w->Cd = phi * Cd + keep * w->Cd;
    w->W = 0.0;
    w->dT_1 = seconds > 0.0 ? cooled(w->dT_1, seconds, p->r_1) : w->dT_1;
    w->dT_2 = seconds > 0.0 ? cooled(w->dT_2, seconds, p->r_2) : w->dT_2;
    w->dT_3 = seconds > 0.0 ? cooled(w->dT_3, seconds, p->r_3) : w->dT_3;
    w->dT_4 = seconds > 0.0 ? cooled(w->dT_4, seconds, p->r_4) : w->dT_4;
    t->seconds += c->dress_seconds, t->dresses += 1.0, t->dressed_off += removed;
    t->power_1 = t->power_2 = t->power_3 = t->power_4 = t->power_5 = t->power_6 = t->last_count = t->deepened = 0.0;
}

static int finished(const Cycle *c, const Progress *p) { return (p->depth >= c->depth) & (p->left <= 0.0); }

/* Run the machines in `order`; each table has one row per machine, with the fields of its record. */
void run(const Cycle *cycles, const Parameters *parameters, Wheel *wheels, Part *parts, Tally *tallies,
         const int64_t *order, int64_t machines) {
    _Alignas(64) Lanes rows;
    int64_t machine[LANES], upcoming = 0;
    int running = 0, started = 0;
    memset(&rows, 0, sizeof rows);
    for (int lane = 0; lane < LANES; lane++) machine[lane] = -1;
    for (;;) {
        for (int lane = 0; lane < LANES; lane++) {
            int due = rows.event[lane] > 0.0 && machine[lane] >= 0;
            while (due || (machine[lane] < 0 && upcoming < machines)) {
                if (machine[lane] < 0) {
                    int64_t i = machine[lane] = order[upcoming++];
                    put_Cycle(&rows.cycle, lane, cycles[i]);
                    put_Constants(&rows.slow, lane, constants_of(&parameters[i], cycles[i].slow, cycles[i].length));
                    put_Constants(&rows.held, lane, constants_of(&parameters[i], cycles[i].speed, cycles[i].length));
                    put_Wheel(&rows.wheel, lane, wheels[i]);
                    put_Part(&rows.part, lane, parts[i]);
                    Progress begun = {.left = cycles[i].at_depth, .dresses = cycles[i].pre_dress};
                    put_Progress(&rows.progress, lane, begun);
                    put_Tally(&rows.tally, lane, tallies[i]);
                    running++;
                }
                int64_t i = machine[lane];
                Wheel wheel = get_Wheel(&rows.wheel, lane);
                Tally tally = get_Tally(&rows.tally, lane);
                Progress progress = get_Progress(&rows.progress, lane);
                for (int n = 0; n < (int)progress.dresses; n++) dress(&cycles[i], &parameters[i], &wheel, &tally);
                put_Wheel(&rows.wheel, lane, wheel);
                put_Tally(&rows.tally, lane, tally);
                due = 0;
                if (finished(&cycles[i], &progress)) {
                    wheels[i] = wheel;
                    parts[i] = get_Part(&rows.part, lane);
                    tallies[i] = tally;
                    running--;
                    machine[lane] = -1;
                }
            }
            if (!started && machine[lane] < 0)
                /* an empty lane repeats the first machine: finite numbers that nobody reads */
                for (double *row = (double *)&rows + lane; row < (double *)(&rows + 1); row += LANES) *row = row[-lane];
        }
        started = 1;
        if (!running) return;
        advance(&rows);
    }
}
