// tests/program/symbols_test.cpp: packets of rays are compiled for processors that may not be this one. Their
// inline functions and templates, which a linker may share, must be in a namespace of their own. Of several
// copies it keeps any, and one made for AVX-512 would end the program elsewhere. Nor may anything of theirs
// run before a processor was asked what it can, or round twice as once.
#include <gmock/gmock.h>
#include <regex>
#include <string>
#include <vector>

#include <cstdio>
#include <memory>

namespace tessera::test {
namespace {

using ::testing::IsEmpty;

std::vector<std::string> linesOf(const std::string& command) {
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    std::vector<std::string> lines(1);
    for (int c = 0; pipe && (c = std::fgetc(pipe.get())) != EOF;) {
        if (c == '\n')
            lines.emplace_back();
        else
            lines.back() += static_cast<char>(c);
    }
    lines.pop_back();
    return lines;
}

/// Of the native engine: the object files of its packets, and the namespace that each is compiled in.
struct PacketObject {
    std::string path, target;
};
std::vector<PacketObject> packetObjects() {
    const std::string all = TESSERA_NATIVE_OBJECTS;
    const std::regex name("([^:]*/packet_(baseline|avx2|avx512)\\.cpp\\.o)(:|$)");
    std::vector<PacketObject> objects;
    for (std::sregex_iterator found(all.begin(), all.end(), name), end; found != end; ++found)
        objects.push_back({(*found)[1], (*found)[2]});
    return objects;
}

class Packets : public testing::Test {
  protected:
    void SetUp() override {
#if TESSERA_X86_TARGETS
        ASSERT_EQ(packetObjects().size(), 3u) << TESSERA_NATIVE_OBJECTS;
#else
        ASSERT_EQ(packetObjects().size(), 1u) << TESSERA_NATIVE_OBJECTS;
#endif
    }
};

TEST_F(Packets, ShareNoSymbolWithTheRestOfTheProgram) {
    const std::regex form("[0-9a-f]* *([A-Za-z?-]) (.*)"),
        own("tessera::native::k\\w+Target|DW\\.ref\\.\\w+"); // the latter is data: how to unwind
    for (const PacketObject& object : packetObjects()) {
        SCOPED_TRACE(object.path);
        const std::string space = "lanes_" + object.target + "::";
        std::vector<std::string> leaks, early;
        std::size_t shared = 0;
        for (const std::string& line : linesOf(TESSERA_NM " -C '" + object.path + "'")) {
            std::smatch part;
            ASSERT_TRUE(std::regex_match(line, part, form)) << line;
            const char kind = part.str(1)[0];
            const std::string symbol = part[2];
            if (symbol.find("_GLOBAL__sub_I") != std::string::npos)
                early.push_back(line);
            // Small letters are the file's own, but for weak, unique and indirect ones.
            const bool isShared = kind != 'U' && ((kind >= 'A' && kind <= 'Z') || kind == 'w' ||
                                                  kind == 'v' || kind == 'u' || kind == 'i');
            if (!isShared || std::regex_match(symbol, own))
                continue;
            ++shared;
            if (symbol.find(space) == std::string::npos)
                leaks.push_back(line);
        }
        EXPECT_THAT(leaks, IsEmpty());
        EXPECT_THAT(early, IsEmpty()) << "runs before main()";
        EXPECT_GT(shared, 5u) << "the packets' own: else this test looks at nothing";
    }
}

TEST_F(Packets, RoundEveryOperation) {
    // One rounding of a*b+c: x86, then arm64.
    const std::regex fused("\\s(vfn?m(add|sub)\\w*|fn?m(add|sub)|fml[as]2?)\\s");
    for (const PacketObject& object : packetObjects()) {
        SCOPED_TRACE(object.path);
        std::vector<std::string> found;
        const std::vector<std::string> lines =
            linesOf(TESSERA_OBJDUMP " -d --no-show-raw-insn '" + object.path + "'");
        for (const std::string& line : lines)
            if ((line.find("fm") != std::string::npos || line.find("fnm") != std::string::npos) &&
                std::regex_search(line, fused))
                found.push_back(line);
        EXPECT_THAT(found, IsEmpty());
        EXPECT_GT(lines.size(), 1000u) << "instructions: else this test looks at nothing";
    }
}

} // namespace
} // namespace tessera::test
