// render/verify/error_goal.h: levels, step and samples of a pixel for an error goal, before and after a
// picture's error has been measured. Predictions choose, measurements decide.
#pragma once

#include "render/verify/measured_errors.h"

#include <string>

namespace tessera {

class ErrorGoal {
  public:
    /// Largest number of pictures for one goal.
    static constexpr int kMostRounds = 6;

    /// @param asked  CIE L*u*v*, 99th percentile over pixels, above 0
    explicit ErrorGoal(double asked) : asked_(asked) {}

    double asked() const { return asked_; }
    /// Allowed predicted error of levels and step together.
    double ofRays() const { return asked_ * rays_; }
    /// Allowed standard error of a pixel's mean over its samples, L*u*v*.
    double ofSamples() const;

    enum class Verdict { reached, goOn, notReached };
    /// @param all  with a bound at chanceOfAttempt() of this round
    /// @param raysAreFinest  no level or step is finer
    /// @param samplesAreMost  no pixel can or should get more samples
    Verdict judge(const MeasuredErrors& all, const MeasuredErrors& samples, const MeasuredErrors& rays,
                  bool raysAreFinest, bool samplesAreMost);
    /// Why it was not reached, and what was; empty if it was.
    const std::string& shortfall() const { return shortfall_; }

  private:
    double asked_;
    double rays_ = 0.7, samples_ = 1; // parts of the requested error
    int rounds_ = 0;
    std::string shortfall_;
};

} // namespace tessera
