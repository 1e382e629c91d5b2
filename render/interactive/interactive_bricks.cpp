// render/interactive/interactive_bricks.cpp: moves of bricks to their chosen levels: the part of
// interactive_volume.h that loads, places and evicts. See render/README.md for the states of a brick.
#include "core/base/error.h"
#include "render/interactive/interactive_volume.h"

#include <algorithm>
#include <exception>

namespace tessera {
namespace {

constexpr std::size_t kMostWanted = 1024; // chunks, of a list that is updated after every step

} // namespace

void InteractiveVolume::setLevel(std::size_t brick, std::uint8_t level) {
    Selection& s = p_.layer().selection;
    --s.counts[s.levels[brick]];
    s.levels[brick] = level;
    ++s.counts[level];
    forDevice_.add(kLevelsChanged);
}

void InteractiveVolume::drop(std::size_t brick) {
    engine_->bricks()->dropToMean(brick, p_.layer().selection.means[brick]);
    if (p_.layer().selection.levels[brick] != Selection::kEmpty)
        setLevel(brick, kMean);
}

/// The finest level at which all visible bricks take at most a quarter of the pages.
int InteractiveVolume::coarseLevel() const {
    const std::size_t shown = p_.layer().selection.shownBricks(), most = std::max<std::size_t>(1, pages_ / 4);
    int level = 1;
    while (level < kMean && PageAllocator::pagesFor(shown, level) > most)
        ++level;
    return level;
}

void InteractiveVolume::planMoves() {
    moves_ = movesTo(p_.layer().selection, *wanted_, gain_, direct_ ? kMean : coarseLevel());
    if (!failed_.empty())
        std::erase_if(moves_, [&](const Move& m) {
            return m.level != kMean &&
                   failed_.contains(chunkOf(m.brick, m.level, p_.layer().selection.bricks));
        });
    wantChunks();
}

void InteractiveVolume::lookAhead(const Choice& choice) {
    const std::size_t most = p_.layer().cache->pinnableChunks();
    for (const int coarse : {coarseLevel(), kMean}) // first coarse levels, then the refinements
        for (const ChunkKey& key :
             chunksOf(movesTo(p_.layer().selection, choice.selection, choice.gain, coarse),
                      p_.layer().selection.bricks, most))
            if (std::find(ahead_.begin(), ahead_.end(), key) == ahead_.end())
                ahead_.push_back(key);
    wantChunks();
}

void InteractiveVolume::wantChunks() {
    std::vector<ChunkKey> keys = chunksOf(moves_, p_.layer().selection.bricks, kMostWanted);
    for (const ChunkKey& key : ahead_)
        if (keys.size() < kMostWanted && std::find(keys.begin(), keys.end(), key) == keys.end())
            keys.push_back(key);
    p_.layer().cache->want(keys);
}

void InteractiveVolume::moveBricks(Work& work) {
    if (!wanted_ || moves_.empty())
        return;
    std::vector<Move> left;
    std::vector<BrickToPlace> run;
    std::size_t chunks = 0, at = 0;
    const std::uint64_t uploaded = work.bytesUploaded;
    bool room = true;
    std::exception_ptr failure;
    while (room && at < moves_.size()) {
        if (moves_[at].level == kMean) {
            drop(moves_[at++].brick);
            continue;
        }
        if (work.bytesUploaded - uploaded >= options_.uploadBytes || chunks++ >= kMostWanted)
            break;
        // All moves of one chunk, which are adjacent.
        const ChunkKey key = chunkOf(moves_[at].brick, moves_[at].level, p_.layer().selection.bricks);
        std::size_t end = at;
        while (end < moves_.size() && moves_[end].level != kMean &&
               chunkOf(moves_[end].brick, moves_[end].level, p_.layer().selection.bricks) == key)
            ++end;
        ChunkPointer chunk;
        try {
            chunk = p_.layer().cache->take(key);
        } catch (...) { // its bricks keep their levels; the caller gets the error once
            failed_.insert(key);
            failure = std::current_exception();
            at = end;
            continue;
        }
        if (chunk) {
            run.clear();
            for (std::size_t n = at; n < end; ++n)
                run.push_back({moves_[n].brick, moves_[n].level, chunk});
            const std::size_t placed = engine_->bricks()->place(run, work);
            for (std::size_t n = 0; n < placed; ++n)
                setLevel(run[n].brick, static_cast<std::uint8_t>(run[n].level));
            room = placed == run.size();
            at += placed;
        } else {
            left.insert(left.end(), moves_.begin() + static_cast<std::ptrdiff_t>(at),
                        moves_.begin() + static_cast<std::ptrdiff_t>(end));
            at = end;
        }
    }
    left.insert(left.end(), moves_.begin() + static_cast<std::ptrdiff_t>(at), moves_.end());
    const bool moved = left.size() < moves_.size();
    const std::size_t blocked = left.size() - (moves_.size() - at); // its position in the rest
    moves_ = std::move(left);
    if (!room)
        makeRoom(moves_[blocked]);
    else if (moves_.empty())
        planMoves(); // bricks that have their coarse level now
    else if (moved)
        wantChunks();
    if (failure)
        std::rethrow_exception(failure);
}

void InteractiveVolume::makeRoom(const Move& blocked) {
    const auto& levels = p_.layer().selection.levels;
    if (levels[blocked.brick] < blocked.level) {
        drop(blocked.brick); // it frees more than it needs
    } else if (std::any_of(moves_.begin(), moves_.end(),
                           [&](const Move& m) { return levels[m.brick] < m.level; })) {
        wantChunks(); // those free memory once their chunks are loaded
        return;
    } else if (const std::vector<std::size_t> sparse = engine_->bricks()->bricksOfSparsestPage();
               !sparse.empty()) {
        for (const std::size_t b : sparse)
            drop(b);
    } else {
        // Pages are blocked whose bricks fit nowhere else. The wanted bricks alone, repacked, all fit.
        TESSERA_CHECK(!direct_);
        for (std::size_t b = 0; b < levels.size(); ++b)
            if (levels[b] < kMean)
                drop(b);
        direct_ = true;
        ++repacks_;
    }
    planMoves();
}

} // namespace tessera
