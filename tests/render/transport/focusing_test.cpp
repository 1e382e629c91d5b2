// Importance sampling as the course notes have it (8.3, 8.4): rejection, and directions of a hemisphere that
// are focused. The product draws lobes and skies exactly instead; their densities are the measure.
#include "render/transport/path_numbers.h"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

namespace tessera {
namespace {

PathNumbers focusNumbers(int n) {
    return PathNumbers({static_cast<float>(n % 4096), static_cast<float>(n / 4096)}, 11);
}

/// Even directions of a hemisphere, drawn towards its axis h so that those of a lobe cos^s above a threshold
/// are met (8.11 to 8.14).
struct Focus {
    Focus(double exponent, double threshold)
        : angle(std::acos(std::pow(threshold, 1 / exponent))),
          alpha(std::tan(angle) / (1 + std::tan(angle))) {}
    glm::dvec3 drawn(const glm::dvec3& h, const glm::dvec3& even) const {
        return glm::normalize(alpha * even + (1 - alpha) * h);
    }
    /// Per steradian. The notes have none.
    double density(double cosine) const {
        const double b = 1 - alpha, under = alpha * alpha - b * b * (1 - cosine * cosine);
        if (cosine < std::cos(angle) || !(under > 0))
            return 0;
        const double l = b * cosine + std::sqrt(under);
        return l * l / (2 * M_PI * alpha * std::abs(l - b * cosine));
    }
    double angle, alpha;
};

TEST(Focusing, HasTheNumbersOfTheNotes) {
    const struct {
        double exponent, degrees, alpha;
    } rows[] = {
        {1, 84.3, 0.909}, {5, 50.9, 0.552}, {20, 27.0, 0.337}, {100, 12.3, 0.178}, {1000, 3.9, 0.064}};
    for (const auto& row : rows) {
        const Focus focus(row.exponent, 0.1);
        EXPECT_NEAR(focus.angle * 180 / M_PI, row.degrees, 0.06) << row.exponent;
        EXPECT_NEAR(focus.alpha, row.alpha, 0.001) << row.exponent;
        EXPECT_NEAR(focus.alpha, (1 + std::tan(focus.angle - M_PI / 4)) / 2, 1e-12);
    }
}

TEST(Focusing, HasADensityOfOne) {
    constexpr int kFine = 200000;
    for (const double exponent : {1.0, 5.0, 20.0, 100.0, 1000.0}) {
        const Focus focus(exponent, 0.1);
        double sum = 0;
        for (int n = 0; n < kFine; ++n) {
            const double a = focus.angle * (n + 0.5) / kFine;
            sum += focus.angle / kFine * 2 * M_PI * std::sin(a) * focus.density(std::cos(a));
        }
        EXPECT_NEAR(sum, 1, 1e-6) << exponent;
    }
}

/// A lobe's integral above the threshold is 2 pi/(s + 1) (1 - cos^(s + 1)) at the rim. Divided by their
/// density, focused directions come to it; as a plain mean over the cone, as the notes take it, they do not.
TEST(Focusing, IsUnbiasedByItsDensityAlone) {
    constexpr int kMany = 400000;
    const glm::dvec3 h = glm::normalize(glm::dvec3(0.3, -0.5, 0.8));
    for (const double exponent : {1.0, 5.0, 20.0, 100.0, 1000.0}) {
        const Focus focus(exponent, 0.1);
        const double rim = std::cos(focus.angle),
                     expected = 2 * M_PI / (exponent + 1) * (1 - std::pow(rim, exponent + 1));
        double sum = 0, squares = 0, plain = 0;
        for (int n = 0; n < kMany; ++n) {
            PathNumbers numbers = focusNumbers(n);
            const float z = numbers.next();
            const glm::dvec3 even(directionAround(glm::vec3(h), z, numbers.next()));
            const double cosine = glm::dot(focus.drawn(h, even), h);
            const double light = cosine < rim + 1e-9 ? 0 : std::pow(cosine, exponent) / focus.density(cosine);
            sum += light, squares += light * light;
            plain += 2 * M_PI * (1 - rim) * std::pow(cosine, exponent);
        }
        const double mean = sum / kMany, error = std::sqrt((squares / kMany - mean * mean) / kMany);
        EXPECT_NEAR(mean, expected, 4 * error + 1e-4 * expected) << exponent;
        EXPECT_LT(error, 0.01 * expected);
        if (exponent > 1) { // of 1 nearly the whole hemisphere is met
            EXPECT_GT(std::abs(plain / kMany / expected - 1), 0.02) << exponent;
        }
    }
}

/// Points of a cube that are in its ball, normalised (8.10), and the closed form that paths take.
TEST(EvenDirections, AreThoseOfRejection) {
    constexpr int kMany = 400000, kHeights = 8, kTurns = 8;
    std::vector<double> rejected(kHeights * kTurns), closed(rejected.size());
    const auto count = [&](std::vector<double>& cells, const glm::dvec3& d) {
        const int height = std::min(static_cast<int>((d.z + 1) / 2 * kHeights), kHeights - 1);
        const double turn = std::atan2(d.y, d.x) / (2 * M_PI) + 0.5;
        ++cells[static_cast<std::size_t>(height * kTurns +
                                         std::min(static_cast<int>(turn * kTurns), kTurns - 1))];
    };
    double inside = 0;
    for (int n = 0; n < kMany; ++n) {
        PathNumbers numbers = focusNumbers(n);
        const float z = numbers.next();
        count(closed, glm::dvec3(directionAround({0, 0, 1}, 1 - 2 * z, numbers.next())));
        glm::dvec3 p(0);
        for (int axis = 0; axis < 3; ++axis)
            p[axis] = 2 * static_cast<double>(numbers.next()) - 1;
        if (glm::length(p) <= 1 && glm::length(p) > 0)
            count(rejected, glm::normalize(p)), ++inside;
    }
    EXPECT_NEAR(inside / kMany, M_PI / 6, 0.004);
    for (const auto& [cells, all] : {std::pair{&closed, double{kMany}}, {&rejected, inside}}) {
        double chi = 0;
        for (const double met : *cells)
            chi += std::pow(met - all / 64, 2) / (all / 64);
        EXPECT_LT(chi, 64 + 5 * std::sqrt(128.0));
    }
}

} // namespace
} // namespace tessera
