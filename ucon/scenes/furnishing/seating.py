"""Tables and desks with their seats; the room's type decides how its tables are used."""

from __future__ import annotations

from ucon.scenes.furnishing import groups as g
from ucon.scenes.furnishing.counters import CounterPlacer

WORK_ROOMS = ("private_office", "bedroom", "childs_room", "phone_room", "shared_office", "lobby", "garage")
SEAT_ROOMS = ("dining_room", "kitchen", "break_room", "meeting_room", "conference_hall", "garden", "playroom", "bar")
TABLES = ("conference_table", "breakfast_table", "pedestal_table", "desk")
SEATS = ("straight_chair", "armchair", "swivel_chair", "taboret", "garden_chair", "eames_chair")


class TablePlacer(CounterPlacer):
    """Adds tables and desks to :class:`CounterPlacer`."""

    def tables(self) -> None:
        """Place desks with a chair at walls, and tables with seats in the middle."""
        w = self.wants
        if self.type == "shared_office" and w["desk"] >= 4:
            self._office_rows()
        if self.type == "conference_hall" and w["desk"]:
            group = g.lecture("desk", g.size_of("desk"), "armchair", min(w["armchair"], 12), self.tint)
            if self.middle(group, "lecture", turns=(0, 1, 2, 3)):
                self._count(group)
        seats = sorted(SEATS, key=lambda c: -w[c])
        chairs = [c for c in seats for _ in range(w[c])]
        if self.type in WORK_ROOMS or (self.type not in SEAT_ROOMS and len(chairs) < 3):
            self._desks()
        seat_tables = [t for t in TABLES for _ in range(w[t])]
        for k, table in enumerate(seat_tables):
            seats = sorted(SEATS, key=lambda c: -w[c])
            chairs = [c for c in seats for _ in range(w[c])]
            left = len(seat_tables) - k
            n = min(8, -(-len(chairs) // left) if left > 1 else len(chairs))
            if self.type not in SEAT_ROOMS and k > 0:
                n = 0
            self._place_table(table, chairs[:n], k)
        self._desks()

    def _place_table(self, table: str, chairs: list[str], k: int) -> bool:
        n = len(chairs)
        x, y, z = g.size_of(table)
        if table in ("breakfast_table", "conference_table"):
            x, y = (0.85, 1.2) if n <= 4 else (0.9, 1.7) if n <= 6 else (1.0, 2.2)
        for count in range(n, -1, -1):
            seat = chairs[0] if chairs else "straight_chair"
            count = min(count, sum(c == seat for c in chairs)) if chairs else 0
            around = 0.35 if count == n else 0.15
            group = g.table_with_seats(table, (x, y, z), seat, count, self.tint, around if count else 0.3)
            if (count > 0 or self.type in SEAT_ROOMS) and self.middle(group, f"table/{table}/{k}"):
                self._count(group)
                return True
            if count == 0:
                break
            if count <= 4:
                y = min(y, 1.2)
        return False

    def _office_rows(self) -> None:
        w = self.wants
        for row in range(4):
            for pairs in (3, 2):
                if w["desk"] >= 2 * pairs and w["swivel_chair"] >= 2 * pairs:
                    group = g.bench_of_desks("desk", (0.7, 1.3, 0.75), "swivel_chair", pairs, self.tint)
                    if self.middle(group, f"bench/{row}/{pairs}"):
                        self._count(group)
                        break

    def _desks(self) -> None:
        w = self.wants
        for table in ("desk", "breakfast_table", "pedestal_table", "console_table", "coffee_table"):
            for k in range(w[table]):
                chair = next((c for c in ("swivel_chair", "straight_chair", "armchair") if w[c]), None)
                if table in ("console_table", "coffee_table") or (self.type == "lobby" and table != "desk"):
                    chair = None
                size = {"breakfast_table": (0.7, 1.2, 0.75), "coffee_table": (0.5, 0.9, 0.43)}.get(table)
                for option in dict.fromkeys((chair, None)):
                    group = g.desk(table, g.size_of(table, size), option, None, self.tint)
                    if self.wall(group, f"desk/{table}/{k}", "edge"):
                        self._count(group)
                        break
