#pragma once
namespace tessera {
struct Occlusion { int rays = 32; double radiusMm = 16; double offsetMm = 0; double bias = 0.1; double gamma = 0.6; double emission = 0; };
}
