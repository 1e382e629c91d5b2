// core/scene/gradient_opacity.h: gradient opacity: a factor on a transfer function's extinction, by the
// length of the field's gradient (docs/sampling.md, "Gradient opacity").
#pragma once

#include <string>
#include <vector>

namespace tessera {

struct GradientPoint {
    double length = 0; // of the gradient, physical units per mm, or per voxel
    double factor = 1; // [0,1]
    bool operator==(const GradientPoint&) const = default;
};

/// Linear between points, constant beyond the outermost. Two points at one length are a step; the length
/// itself takes the right one.
class GradientOpacity {
  public:
    /// The unit of lengths: per millimetre, or per mean of a volume's three spacings, as in VTK
    /// (vtkVolumeShaderComposer.h, computeGradient()).
    enum class Per { mm, voxel };
    static constexpr std::size_t kMostPoints = 16;

    /// 1 everywhere.
    GradientOpacity() = default;
    /// Points in any order; sorted stably. Factors are clamped to [0,1]. If all factors are 1, there are no
    /// points. Throws InputError naming where for lengths and factors that are not finite, lengths below 0,
    /// and more than kMostPoints.
    static GradientOpacity fromPoints(std::vector<GradientPoint> points, Per per = Per::mm,
                                      const std::string& where = "gradient opacity");

    bool isOne() const { return points_.empty(); }
    const std::vector<GradientPoint>& points() const { return points_; }
    Per per() const { return per_; }
    /// @param length  in the points' unit
    double factor(double length) const;
    /// The same of lengths per mm.
    /// @param spacingMm  of the volume, the mean over its axes
    GradientOpacity perMm(double spacingMm) const;
    bool operator==(const GradientOpacity&) const = default;

  private:
    std::vector<GradientPoint> points_; // by length
    Per per_ = Per::mm;
};

} // namespace tessera
