"""A cast of faces made from numbers: who somebody is, and the head, skin, hair and eyes that follow from it."""
