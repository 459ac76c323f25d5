// Threads that build trees of Embree together. In C++, since oneTBB has no C face; no exception leaves these functions.
#include "gi/trace/gi_embree_team.h"

#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include <vector>

namespace
{

struct helper {
	tbb::task_group group;
	tbb::task_handle task; // never run: while it is there, the group is not done
};

// Runs body; false if that threw.
template <typename Body> bool guarded(Body body)
{
	try {
		body();
		return true;
	} catch (...) {
		return false;
	}
}

} // namespace

struct gi_embree_team {
	// All places in the arena are for threads that enter it, so oneTBB starts none of its own.
	explicit gi_embree_team(uint32_t threads) : arena(int(threads), threads), helpers(threads - 1)
	{
	}

	tbb::task_arena arena;
	std::vector<helper> helpers;
};

gi_embree_team *gi_embree_team_create(uint32_t threads)
{
	gi_embree_team *team = nullptr;
	guarded([&] { team = new gi_embree_team(threads); });
	return team;
}

void gi_embree_team_destroy(gi_embree_team *team)
{
	delete team;
}

static void team_dismiss(gi_embree_team *team)
{
	for (helper &each : team->helpers)
		each.task = tbb::task_handle();
}

bool gi_embree_team_call(gi_embree_team *team)
{
	bool called = guarded([&] {
		for (helper &each : team->helpers)
			each.task = each.group.defer([] {});
	});
	if (!called)
		team_dismiss(team);
	return called;
}

void gi_embree_team_help(gi_embree_team *team, uint32_t index)
{
	guarded([&] { team->arena.execute([&] { team->helpers[index].group.wait(); }); }); // or the others go on without it
}

bool gi_embree_team_commit(gi_embree_team *team, RTCScene scene)
{
	bool committed = guarded([&] { team->arena.execute([&] { rtcCommitScene(scene); }); });
	team_dismiss(team);
	return committed;
}
