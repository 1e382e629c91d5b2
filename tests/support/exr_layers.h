// tests/support/exr_layers.h: what an OpenEXR picture has beside its colours, as the file's own library reads
// it.
#pragma once

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tessera::test {

/// Every further channel but those of annotations as means of 4 x 3 fields, row by row from the top; of a
/// field without a finite value null.
inline nlohmann::json layersOf(const std::filesystem::path& path) {
    Imf::InputFile file(path.c_str(), 0);
    const Imath::Box2i window = file.header().dataWindow();
    const int width = window.max.x - window.min.x + 1, height = window.max.y - window.min.y + 1;
    const auto w = static_cast<std::size_t>(width), h = static_cast<std::size_t>(height);
    constexpr int kColumns = 4, kRows = 3;
    nlohmann::json layers = nlohmann::json::object();
    const Imf::ChannelList& channels = file.header().channels();
    for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
        if (std::string("RGBA").find(channel.name()) != std::string::npos ||
            std::string(channel.name()).starts_with("annotations.")) // which depend on fonts
            continue;
        std::vector<float> values(w * h);
        Imf::FrameBuffer buffer;
        buffer.insert(channel.name(), Imf::Slice::Make(Imf::FLOAT, values.data(), window));
        file.setFrameBuffer(buffer);
        file.readPixels(window.min.y, window.max.y);
        nlohmann::json& means = layers[channel.name()] = nlohmann::json::array();
        for (int field = 0; field < kColumns * kRows; ++field) {
            const int column = field % kColumns, row = field / kColumns;
            double sum = 0;
            int count = 0;
            for (int y = row * height / kRows; y < (row + 1) * height / kRows; ++y)
                for (int x = column * width / kColumns; x < (column + 1) * width / kColumns; ++x)
                    if (const float v = values[static_cast<std::size_t>(y) * w + static_cast<std::size_t>(x)];
                        std::isfinite(v)) {
                        sum += static_cast<double>(v);
                        ++count;
                    }
            means.push_back(count > 0 ? nlohmann::json(sum / count) : nlohmann::json());
        }
    }
    return layers;
}

} // namespace tessera::test
