/* What plain C takes for the online kernels: same operations, sizes known to the compiler. */
#include <math.h>
#include <string.h>
#define C 8
#define P 16
#define K 11
#define MAX_S 48
#define ANEW 64

static int cholesky(double *restrict a, int n, int stride, double *restrict log_det) {
  double total_log = 0.0;
  for (int i = 0; i < n; i++)
    for (int j = 0; j <= i; j++) {
      double total = a[i * stride + j];
      for (int m = 0; m < j; m++) total -= a[i * stride + m] * a[j * stride + m];
      if (i == j) {
        a[i * stride + i] = sqrt(total);
        total_log += 2.0 * log(a[i * stride + i]);
      } else a[i * stride + j] = total / a[j * stride + j];
    }
  *log_det = total_log;
  return 0;
}

static double step(double *restrict normal, double *restrict pull, double *restrict theta, double bound) {
  double unused;
  cholesky(normal, P, P, &unused);
  for (int i = 0; i < P; i++) {
    for (int m = 0; m < i; m++) pull[i] -= normal[i * P + m] * pull[m];
    pull[i] /= normal[i * P + i];
  }
  for (int i = P - 1; i >= 0; i--) {
    for (int m = i + 1; m < P; m++) pull[i] -= normal[m * P + i] * pull[m];
    pull[i] /= normal[i * P + i];
  }
  double largest = 0.0;
  for (int i = 0; i < P; i++) {
    theta[i] -= fmin(fmax(pull[i], -bound), bound);
    largest = fmax(largest, fabs(pull[i]));
  }
  return largest;
}

static void features(const double *restrict believed, const double *restrict unit, double *restrict f) {
  for (int i = 0; i < C; i++) { f[i] = believed[i] * unit[i]; f[C + i] = unit[C + i]; }
}

void window_exact(const double *believed, const double *pos, const double *fz, const double *cop,
                  const double *unit, const long *first, const long *stop, long updates,
                  double fw, double cw, double sw, int iterations, double bound, double enough, double least,
                  double *out) {
  double theta[P] = {0}, previous[P], ff[P * P], normal[P * P], pull[P], f[P], sx[P], sy[P];
  for (long j = 0; j < updates; j++) {
    memcpy(previous, theta, sizeof theta);
    long known = first[j];
    if (j % ANEW == 0) memset(ff, 0, sizeof ff);
    else {
      known = stop[j - 1] > first[j] ? stop[j - 1] : first[j];
      for (long n = first[j - 1]; n < (first[j] < stop[j - 1] ? first[j] : stop[j - 1]); n++) {
        features(believed + n * C, unit, f);
        for (int i = 0; i < P; i++) for (int k = 0; k <= i; k++) ff[i * P + k] -= f[i] * f[k];
      }
    }
    for (long n = known; n < stop[j]; n++) {
      features(believed + n * C, unit, f);
      for (int i = 0; i < P; i++) for (int k = 0; k <= i; k++) ff[i * P + k] += f[i] * f[k];
    }
    for (int it = 0; it < (stop[j] > first[j] ? iterations : 0); it++) {
      for (int i = 0; i < P; i++) {
        for (int k = 0; k <= i; k++) normal[i * P + k] = fw * ff[i * P + k];
        normal[i * P + i] += sw;
        pull[i] = sw * (theta[i] - previous[i]);
      }
      for (long n = first[j]; n < stop[j]; n++) {
        features(believed + n * C, unit, f);
        const double *q = pos + n * 2 * C;
        double total = 0, mx = 0, my = 0;
        for (int i = 0; i < C; i++) {
          double force = believed[n * C + i] + theta[i] * f[i] + theta[C + i] * f[C + i];
          total += force; mx += force * q[2 * i]; my += force * q[2 * i + 1];
        }
        double miss = fw * (total - fz[n]);
        for (int i = 0; i < P; i++) pull[i] += miss * f[i];
        if (!(total > least)) continue;
        double x = mx / total, y = my / total, inverse = 1.0 / total;
        for (int i = 0; i < P; i++) {
          int a = i & (C - 1);
          sx[i] = (q[2 * a] - x) * f[i] * inverse; sy[i] = (q[2 * a + 1] - y) * f[i] * inverse;
        }
        double ex = cw * (x - cop[2 * n]), ey = cw * (y - cop[2 * n + 1]);
        for (int i = 0; i < P; i++) {
          pull[i] += sx[i] * ex + sy[i] * ey;
          double wx = cw * sx[i], wy = cw * sy[i];
          for (int k = 0; k <= i; k++) normal[i * P + k] += wx * sx[k] + wy * sy[k];
        }
      }
      if (step(normal, pull, theta, bound) < enough) break;
    }
    memcpy(out + j * P, theta, sizeof theta);
  }
}

#define MOST_BLOCKS 64
void window_sums(const double *believed, const double *pos, const double *fz, const double *cop,
                 const double *unit, const long *edges, long blocks, int length, const double *fw,
                 const double *cw, const double *sw, int settings, double bound, double *theta,
                 double *out) {
  static double rff[MOST_BLOCKS][P * P], rmm[MOST_BLOCKS][P * P], rf[MOST_BLOCKS][P], rm[MOST_BLOCKS][P];
  double ff[P * P] = {0}, mm[P * P] = {0}, pf[P] = {0}, pm[P] = {0};
  double f[P], mx[P], my[P], normal[P * P], pull[P];
  memset(rff, 0, sizeof rff); memset(rmm, 0, sizeof rmm);
  memset(rf, 0, sizeof rf); memset(rm, 0, sizeof rm);
  for (long j = 0; j < blocks; j++) {
    int slot = j % length;
    for (int i = 0; i < P * P; i++) { ff[i] -= rff[slot][i]; mm[i] -= rmm[slot][i]; }
    for (int i = 0; i < P; i++) { pf[i] -= rf[slot][i]; pm[i] -= rm[slot][i]; }
    memset(rff[slot], 0, sizeof ff); memset(rmm[slot], 0, sizeof mm);
    memset(rf[slot], 0, sizeof pf); memset(rm[slot], 0, sizeof pm);
    for (long n = edges[j]; n < edges[j + 1]; n++) {
      features(believed + n * C, unit, f);
      double total = 0, ex = 0, ey = 0, inverse = 1.0 / fz[n];
      for (int i = 0; i < C; i++) {
        double x = (pos[(n * C + i) * 2] - cop[2 * n]) * inverse;
        double y = (pos[(n * C + i) * 2 + 1] - cop[2 * n + 1]) * inverse;
        double b = believed[n * C + i];
        total += b; ex += b * x; ey += b * y;
        mx[i] = f[i] * x; my[i] = f[i] * y; mx[C + i] = f[C + i] * x; my[C + i] = f[C + i] * y;
      }
      double miss = total - fz[n];
      for (int i = 0; i < P; i++) {
        rf[slot][i] += f[i] * miss; rm[slot][i] += mx[i] * ex + my[i] * ey;
        for (int k = 0; k <= i; k++) {
          rff[slot][i * P + k] += f[i] * f[k];
          rmm[slot][i * P + k] += mx[i] * mx[k] + my[i] * my[k];
        }
      }
    }
    for (int i = 0; i < P * P; i++) { ff[i] += rff[slot][i]; mm[i] += rmm[slot][i]; }
    for (int i = 0; i < P; i++) { pf[i] += rf[slot][i]; pm[i] += rm[slot][i]; }
    for (int b = 0; b < settings; b++) {
      double *t = theta + b * P;
      for (int i = 0; i < P; i++) pull[i] = fw[b] * pf[i] + cw[b] * pm[i];
      for (int i = 0; i < P; i++) {
        for (int k = 0; k <= i; k++) {
          double value = fw[b] * ff[i * P + k] + cw[b] * mm[i * P + k];
          normal[i * P + k] = value;
          pull[i] += value * t[k];
          if (k < i) pull[k] += value * t[i];
        }
        normal[i * P + i] += sw[b];
      }
      step(normal, pull, t, bound);
      memcpy(out + (j * settings + b) * P, t, sizeof pull);
    }
  }
}

/* Kalman step with s states, h (u, K, s) ready made, R (u, K, K) ready made: the bare algebra. */
void filter_walk(double *restrict x, double *restrict cov, const double *h, const double *noise,
                 const double *error, const unsigned char *valid, const double *decay,
                 const double *drive, long updates, int s, int p, double huber, double *values) {
  double w[K * MAX_S], total[K * K], nu[K], z[K], before[MAX_S * MAX_S], after[MAX_S * MAX_S];
  for (long j = 0; j < updates; j++) {
    const double *d = decay + j * s;
    for (int m = 0; m < s; m++) {
      x[m] *= d[m];
      for (int n = 0; n < s; n++) cov[m * s + n] *= d[m] * d[n];
      cov[m * s + m] += drive[j * s + m];
    }
    int at[K], rows = 0;
    for (int r = 0; r < K; r++) if (valid[j * K + r]) at[rows++] = r;
    for (int i = 0; i < rows; i++) {
      const double *hi = h + (j * K + at[i]) * s;
      double value = error[j * K + at[i]];
      for (int n = 0; n < s; n++) w[i * s + n] = 0.0;
      for (int m = 0; m < s; m++) {
        value += hi[m] * x[m];
        if (hi[m] != 0.0) for (int n = 0; n < s; n++) w[i * s + n] += hi[m] * cov[m * s + n];
      }
      nu[i] = -value;
    }
    for (int i = 0; i < rows; i++)
      for (int k = 0; k <= i; k++) {
        const double *hk = h + (j * K + at[k]) * s;
        double value = noise[(j * K + at[i]) * K + at[k]];
        for (int m = 0; m < s; m++) value += w[i * s + m] * hk[m];
        total[i * K + k] = i == k ? fmax(value, nu[i] * nu[i] / (huber * huber)) : value;
      }
    double log_det, unused;
    cholesky(total, rows, K, &log_det);
    for (int i = 0; i < rows; i++) {
      double value = nu[i];
      for (int m = 0; m < i; m++) {
        double factor = total[i * K + m];
        value -= factor * z[m];
        for (int n = 0; n < s; n++) w[i * s + n] -= factor * w[m * s + n];
      }
      double scale = 1.0 / total[i * K + i];
      z[i] = value * scale;
      for (int n = 0; n < s; n++) w[i * s + n] *= scale;
    }
    for (int m = 0; m < p; m++)
      for (int n = 0; n <= m; n++) {
        double value = cov[m * s + n];
        before[m * MAX_S + n] = value;
        for (int i = 0; i < rows; i++) value -= w[i * s + m] * w[i * s + n];
        after[m * MAX_S + n] = value;
      }
    cholesky(before, p, MAX_S, &unused);
    cholesky(after, p, MAX_S, &log_det);
    for (int i = 0; i < rows; i++)
      for (int m = 0; m < s; m++) {
        x[m] += w[i * s + m] * z[i];
        for (int n = 0; n < s; n++) cov[m * s + n] -= w[i * s + m] * w[i * s + n];
      }
    for (int m = 0; m < p; m++) values[j * p + m] = x[m];
  }
}
