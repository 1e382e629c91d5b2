// render/verify/error_goal.h: levels, step and samples of a pixel for an error goal, before and after a
// picture's error has been measured. Predictions choose, measurements decide.
#pragma once

#include "render/verify/measured_errors.h"

#include <string>

namespace tessera {

class ErrorGoal {
  public:
    /// Pictures that are drawn for one goal, at most.
    static constexpr int kMostRounds = 6;

    /// @param asked  CIE L*u*v*, 99th percentile over pixels, above 0
    explicit ErrorGoal(double asked) : asked_(asked) {}

    double asked() const { return asked_; }
    /// What levels and step may cost together, by their prediction.
    double ofRays() const { return asked_ * rays_; }
    /// What a pixel's mean over its samples may be off: its standard error, L*u*v*.
    double ofSamples() const;

    enum class Verdict { reached, goOn, notReached };
    /// @param all  its bound holds with chanceOfAttempt() of this round
    /// @param raysAreFinest  no level or step is finer
    /// @param samplesAreMost  no pixel can get more samples, or none is to
    Verdict judge(const MeasuredErrors& all, const MeasuredErrors& samples, const MeasuredErrors& rays,
                  bool raysAreFinest, bool samplesAreMost);
    /// Why it was not reached, and what was; empty where it was.
    const std::string& shortfall() const { return shortfall_; }

  private:
    double asked_;
    double rays_ = 0.7, samples_ = 1; // parts of what is asked
    int rounds_ = 0;
    std::string shortfall_;
};

} // namespace tessera
