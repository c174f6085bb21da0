/* The return-mapping scheme of jaxstick for many lanes, as one would write it by hand for a vector unit.

   Lanes go in blocks whose state stays in the first-level cache; the innermost loop runs over the lanes of a
   block and is vectorised by the compiler, and blocks are shared among the cores. Sine and exponential are
   polynomials, right to a few units in the last place, so that they are vectorised with the rest.

   `constants` holds twelve rows of `lanes` numbers: mass, stiffness, drive stiffness, damping, A, B, C, D,
   k1, frequency, base amplitude, interval between samples. `displacement` is lanes x samples. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#ifndef BLOCK
#define BLOCK 64
#endif

static inline double clip(double value, double upper) { return fmin(fmax(value, 0.0), upper); }

static inline double sine_of_turns(double turns) {
    double part = turns - rint(turns), size = fabs(part), folded = 4.0 * fmin(size, 0.5 - size);
    double w = folded * folded, p = 5.87297574479995e-12;
    p = p * w - 6.684416831856085e-10;
    p = p * w + 5.6921364280986254e-08;
    p = p * w - 3.5988430204672576e-06;
    p = p * w + 0.0001604411847130916;
    p = p * w - 0.004681754135304255;
    p = p * w + 0.07969262624616565;
    p = p * w - 0.6459640975062462;
    p = p * w + 1.5707963267948966;
    return copysign(folded * p, part);
}

/* exp(x) for x <= 0: a power of two times a Taylor polynomial of degree 11 on |r| <= ln(2)/2. */
static inline double decay(double x) {
    double n = rint(fmax(x, -700.0) * 1.4426950408889634);
    double r = (fmax(x, -700.0) - n * 0.6931471803691238) - n * 1.9082149292705877e-10;
    double p = 1.0 / 39916800.0;
    p = p * r + 1.0 / 3628800.0;
    p = p * r + 1.0 / 362880.0;
    p = p * r + 1.0 / 40320.0;
    p = p * r + 1.0 / 5040.0;
    p = p * r + 1.0 / 720.0;
    p = p * r + 1.0 / 120.0;
    p = p * r + 1.0 / 24.0;
    p = p * r + 1.0 / 6.0;
    p = p * r + 0.5;
    p = p * r + 1.0;
    p = p * r + 1.0;
    int64_t bits = ((int64_t)n + 1023) << 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return p * power;
}

#define ROW(number) (constants + (number) * lanes)

void march_lanes(long lanes, long samples, long steps, const double *constants, double *displacement,
                 int threads) {
    (void)threads;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (long first = 0; first < lanes; first += BLOCK) {
        int count = lanes - first < BLOCK ? (int)(lanes - first) : BLOCK;
        double x[BLOCK], behind[BLOCK], ahead[BLOCK], deflection[BLOCK], kept[BLOCK];
        double per_mass[BLOCK], stiffness[BLOCK], push[BLOCK], damping[BLOCK], A[BLOCK], B[BLOCK], C[BLOCK];
        double D[BLOCK], k1[BLOCK], per_k1[BLOCK], step[BLOCK], turn[BLOCK], fitting[BLOCK];
        for (int i = 0; i < BLOCK; i++) {
            long lane = first + (i < count ? i : count - 1);
            per_mass[i] = 1.0 / ROW(0)[lane];
            stiffness[i] = ROW(1)[lane];
            push[i] = ROW(2)[lane] * ROW(10)[lane];
            damping[i] = ROW(3)[lane];
            A[i] = ROW(4)[lane];
            B[i] = ROW(5)[lane];
            C[i] = ROW(6)[lane];
            D[i] = ROW(7)[lane];
            k1[i] = ROW(8)[lane];
            per_k1[i] = 1.0 / k1[i];
            step[i] = ROW(11)[lane] / (double)steps;
            turn[i] = ROW(9)[lane] * step[i];
            double twelfth = k1[i] * step[i] * step[i] * per_mass[i] / 12.0;
            fitting[i] = twelfth * (1.0 + twelfth);
            x[i] = behind[i] = ahead[i] = deflection[i] = 0.0;
            kept[i] = -(A[i] + C[i]);
        }
        for (int i = 0; i < count; i++) displacement[(first + i) * samples] = 0.0;
        for (long sample = 1; sample < samples; sample++) {
            for (long number = (sample - 1) * steps + 1; number <= sample * steps; number++) {
                double time = (double)number;
#pragma omp simd
                for (int i = 0; i < BLOCK; i++) {
                    double h = step[i], slide = h * ahead[i], mobility = 0.5 * h * per_mass[i];
                    double expected = 1.5 * ahead[i] - 0.5 * behind[i];
                    double place = x[i] + slide;
                    double force = push[i] * sine_of_turns(turn[i] * time) - stiffness[i] * place;
                    double unheld = (force - damping[i] * expected) * per_mass[i];
                    double trial = deflection[i] + slide, sense = trial < 0.0 ? -1.0 : 1.0;
                    double limit = A[i] * decay(-B[i] * fabs(expected)) + C[i];
                    double excess = k1[i] * fabs(trial) - limit, before = kept[i];
                    int loads = slide * sense > 0.0, slid = before > 0.0;
                    double change = excess - before, size = change == 0.0 ? 1.0 : fabs(change);
                    double breaking = change > 0.0 ? clip(excess + 0.5 * size, size) : 0.0;
                    double ending = change < 0.0 ? clip(excess, size) : size;
                    double slipped = slid ? ending : breaking;
                    double share = (loads ? slipped : 0.0) / size;
                    double lack = slid ? 0.0 : 0.5 * (1.0 - share) * (1.0 - share) * change;
                    double mean = share > 0.0 ? sense * (lack - limit) : -k1[i] * trial;
                    double coasting = ahead[i] + 0.5 * h * unheld + mobility * mean;
                    double drag = D[i] * coasting / (1.0 + mobility * share * D[i]);
                    double total = unheld + (mean - share * drag) * per_mass[i];
                    double reached = total / (1.0 + (1.0 - share) * fitting[i]);
                    int slips = loads & (excess > 0.0);
                    x[i] = place;
                    behind[i] = ahead[i];
                    ahead[i] += h * reached;
                    deflection[i] = slips ? sense * limit * per_k1[i] : trial;
                    kept[i] = slips ? excess : fmin(excess, 0.0);
                }
            }
            for (int i = 0; i < count; i++) displacement[(first + i) * samples + sample] = x[i];
        }
    }
}
