"""Contents of generated homes: the rooms of each kind of home, and sizes and contents of each type of room."""

from __future__ import annotations

#: By room type: least and greatest width, least and greatest length, metres.
SIZES_M: dict[str, tuple[float, float, float, float]] = {
    "bathroom": (2.0, 2.75, 2.5, 3.5),
    "bedroom": (3.0, 4.25, 3.5, 5.0),
    "childs_room": (3.0, 3.75, 3.5, 4.5),
    "kitchen": (2.75, 4.0, 3.5, 5.0),
    "living_room": (4.0, 5.25, 4.75, 6.5),
    "television_room": (4.0, 5.0, 4.75, 6.0),
    "dining_room": (3.0, 4.0, 3.5, 5.0),
    "private_office": (2.75, 3.75, 3.25, 4.25),
    "utility_room": (2.0, 2.75, 2.5, 3.5),
    "storage_room": (1.75, 2.25, 2.0, 3.0),
    "closet": (1.75, 2.0, 2.0, 2.75),
    "pantry_room": (1.75, 2.25, 2.25, 3.0),
    "playroom": (3.5, 4.5, 4.0, 5.5),
    "garage": (3.5, 5.5, 6.0, 7.0),
    "entryway": (1.75, 2.5, 2.25, 3.25),
    "exercise_room": (3.25, 4.0, 3.75, 4.75),
    "meeting_room": (3.25, 4.25, 4.0, 5.5),
    "conference_hall": (5.5, 6.5, 6.5, 8.5),
    "shared_office": (6.0, 8.0, 7.5, 10.0),
    "break_room": (4.0, 5.0, 4.5, 6.0),
    "lobby": (4.5, 5.5, 5.5, 7.0),
    "copy_room": (2.25, 2.75, 2.5, 3.25),
    "phone_room": (1.75, 2.0, 2.0, 2.5),
    "bar": (2.75, 3.5, 4.0, 5.0),
    "grocery_store": (7.5, 10.0, 9.0, 12.0),
    "garden": (7.0, 9.0, 8.0, 11.0),
}
BIG: dict[str, tuple[float, float, float, float]] = {
    "dining_room": (7.0, 8.5, 8.0, 10.0),
    "kitchen": (4.5, 6.0, 5.5, 7.0),
    "bathroom": (3.0, 3.5, 3.75, 4.5),
}
"""The same for rooms of restaurants, and for bathrooms of shops."""
#: By room type: basic furniture, as (category, least, most).
MUST: dict[str, tuple[tuple[str, int, int], ...]] = {
    "bathroom": (("sink", 1, 1), ("toilet", 1, 1), ("mirror", 1, 1), ("towel_rack", 1, 1), ("trash_can", 0, 1)),
    "bedroom": (("bed", 1, 1), ("nightstand", 1, 2), ("table_lamp", 1, 2), ("wardrobe", 1, 1), ("carpet", 0, 1)),
    "childs_room": (("bed", 1, 1), ("desk", 1, 1), ("swivel_chair", 1, 1), ("shelf", 1, 1), ("toy_box", 0, 1)),
    "kitchen": (
        ("countertop", 2, 2),
        ("bottom_cabinet_no_top", 3, 5),
        ("top_cabinet", 2, 5),
        ("sink", 1, 1),
        ("fridge", 1, 1),
        ("oven", 1, 1),
        ("dishwasher", 0, 1),
        ("trash_can", 1, 1),
    ),
    "living_room": (
        ("sofa", 1, 1),
        ("coffee_table", 1, 1),
        ("wall_mounted_tv", 1, 1),
        ("bottom_cabinet", 1, 2),
        ("carpet", 1, 1),
        ("shelf", 1, 2),
        ("armchair", 1, 2),
        ("floor_lamp", 1, 1),
        ("pot_plant", 1, 2),
        ("picture", 1, 3),
    ),
    "television_room": (
        ("sofa", 1, 1),
        ("standing_tv", 1, 1),
        ("bottom_cabinet", 1, 1),
        ("coffee_table", 1, 1),
        ("shelf", 1, 2),
    ),
    "dining_room": (("breakfast_table", 1, 1), ("straight_chair", 4, 6), ("console_table", 0, 1), ("pot_plant", 0, 1)),
    "private_office": (
        ("desk", 1, 1),
        ("swivel_chair", 1, 1),
        ("monitor", 1, 1),
        ("shelf", 1, 2),
        ("bottom_cabinet", 0, 1),
    ),
    "utility_room": (("washer", 1, 1), ("clothes_dryer", 1, 1), ("top_cabinet", 1, 2), ("sink", 0, 1)),
    "storage_room": (("shelf", 1, 1),),
    "closet": (("wardrobe", 1, 1),),
    "pantry_room": (("shelf", 1, 2),),
    "playroom": (("carpet", 1, 1), ("shelf", 1, 2), ("toy_box", 1, 1), ("armchair", 0, 1), ("bottom_cabinet", 0, 1)),
    "garage": (("shelf", 1, 2), ("bottom_cabinet", 1, 1), ("recycling_bin", 0, 1)),
    "entryway": (("hall_tree", 0, 1), ("bottom_cabinet", 1, 1), ("mirror", 0, 1)),
    "exercise_room": (("treadmill", 1, 1), ("bench", 1, 1), ("mirror", 1, 1)),
    "corridor": (("picture", 0, 2), ("console_table", 0, 1)),
    "meeting_room": (
        ("conference_table", 1, 1),
        ("swivel_chair", 4, 6),
        ("wall_mounted_tv", 1, 1),
        ("bottom_cabinet", 0, 1),
    ),
    "conference_hall": (
        ("conference_table", 1, 1),
        ("swivel_chair", 6, 8),
        ("wall_mounted_tv", 1, 1),
        ("bottom_cabinet", 1, 2),
    ),
    "shared_office": (("desk", 4, 8), ("bottom_cabinet", 2, 4), ("pot_plant", 1, 2)),
    "break_room": (
        ("breakfast_table", 1, 1),
        ("straight_chair", 4, 4),
        ("fridge", 1, 1),
        ("sink", 1, 1),
        ("bottom_cabinet", 1, 2),
    ),
    "lobby": (
        ("reception_desk", 1, 1),
        ("sofa", 1, 2),
        ("coffee_table", 1, 1),
        ("armchair", 1, 2),
        ("pot_plant", 1, 2),
    ),
    "copy_room": (("photocopier", 1, 1), ("bottom_cabinet", 1, 1), ("trash_can", 1, 1), ("shelf", 0, 1)),
    "phone_room": (("desk", 1, 1),),
    "bar": (("bar", 1, 1), ("taboret", 2, 4), ("shelf", 1, 2), ("fridge", 0, 1)),
    "grocery_store": (("grocery_shelf", 8, 14), ("checkout_counter", 1, 2), ("shopping_cart", 2, 3)),
    "garden": (("garden_chair", 2, 3), ("breakfast_table", 1, 1), ("tree", 2, 4), ("bush", 3, 6), ("grill", 0, 1)),
}
#: By room type: further small things, as (category, probability).
CLUTTER: dict[str, tuple[tuple[str, float], ...]] = {
    "bathroom": (("soap_dispenser", 0.7), ("hamper", 0.3), ("bottle_of_shampoo", 0.4)),
    "bedroom": (("pillow", 1.0), ("alarm_clock", 0.5), ("paperback_book", 0.5), ("hamper", 0.3)),
    "childs_room": (("pillow", 1.0), ("toy_figure", 0.6), ("pencil", 0.5), ("paperback_book", 0.6)),
    "kitchen": (
        ("microwave", 0.8),
        ("coffee_maker", 0.6),
        ("kettle", 0.5),
        ("toaster", 0.5),
        ("bowl", 0.6),
        ("cutting_board", 0.5),
    ),
    "living_room": (("pillow", 0.9), ("hardback", 0.6), ("vase", 0.5), ("magazine", 0.5), ("wicker_basket", 0.4)),
    "television_room": (("pillow", 0.8), ("magazine", 0.5)),
    "dining_room": (("vase", 0.6), ("bowl", 0.4)),
    "private_office": (("laptop", 0.7), ("keyboard", 0.6), ("notebook", 0.6), ("pencil_holder", 0.5)),
    "utility_room": (("wicker_basket", 0.7), ("detergent_bottle", 0.7), ("bucket", 0.4)),
    "storage_room": (("storage_box", 0.9), ("toolbox", 0.5), ("suitcase", 0.3)),
    "closet": (("hamper", 0.5), ("storage_box", 0.5)),
    "pantry_room": (("jar", 0.8), ("storage_box", 0.5)),
    "garage": (("toolbox", 0.8), ("storage_box", 0.8), ("bucket", 0.4)),
    "entryway": (("shoulder_bag", 0.5), ("gym_shoe", 0.6)),
    "shared_office": (("laptop", 0.6), ("notebook", 0.6)),
    "break_room": (("coffee_maker", 0.9), ("mug", 0.8), ("microwave", 0.7)),
    "bar": (("wineglass", 0.8), ("bottle_of_wine", 0.8)),
    "phone_room": (("desk_phone", 0.9),),
    "lobby": (("magazine", 0.8),),
}
NO_WINDOWS = ("corridor", "closet", "storage_room", "pantry_room", "garden", "phone_room", "copy_room")
FLAT_POOL = (
    "private_office",
    "closet",
    "bedroom",
    "dining_room",
    "storage_room",
    "entryway",
    "bathroom",
    "utility_room",
)
HOUSE_POOL = (
    "bedroom", "dining_room", "bathroom", "childs_room", "private_office", "utility_room", "closet", "storage_room",
    "television_room", "playroom", "garage", "pantry_room", "entryway", "closet", "exercise_room",
)  # fmt: skip
OFFICE_POOL = (
    "private_office", "meeting_room", "copy_room", "private_office", "storage_room", "phone_room", "meeting_room",
    "conference_hall", "private_office", "lobby", "shared_office",
)  # fmt: skip
RESTAURANT_POOL = ("bar", "storage_room", "private_office", "pantry_room", "dining_room", "utility_room")
SHOP_POOL = ("storage_room", "private_office", "break_room", "storage_room", "bar", "dining_room")
#: By kind of home: rooms that are always there, rooms to choose from, greatest number of rooms.
KIND_ROOMS: dict[str, tuple[tuple[str, ...], tuple[str, ...], int]] = {
    "house": (("living_room", "kitchen", "bathroom", "bedroom"), HOUSE_POOL, 15),
    "flat": (("living_room", "kitchen", "bathroom", "bedroom"), FLAT_POOL, 8),
    "office": (("shared_office", "break_room", "bathroom", "private_office"), OFFICE_POOL, 14),
    "restaurant": (("dining_room", "kitchen", "bathroom", "storage_room"), RESTAURANT_POOL, 8),
    "shop": (("grocery_store", "storage_room", "bathroom", "private_office"), SHOP_POOL, 8),
}
