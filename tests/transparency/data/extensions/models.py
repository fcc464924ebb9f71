"""Models of Pydantic (Rust): defaults, limits, literals, errors."""

from typing import Literal

from pydantic import BaseModel, Field, StrictFloat, StrictInt, StrictStr, ValidationError

SPEED = 0.5
COUNT = 3
NAME = "slow"


class Config(BaseModel):
    speed: float = Field(default=0.5, ge=0.0, le=2.0)
    count: int = 3
    mode: Literal["fast", "slow"] = "fast"
    level: Literal[1, 2, 3] = 2
    gains: list[float] = [1.0, SPEED]
    exact: StrictFloat = 1.5
    whole: StrictInt = 4
    text: StrictStr = "t"
    table: dict[str, int] = {"a": 1}


made = Config(speed=SPEED, mode=NAME, level=COUNT, exact=SPEED, whole=COUNT, table={NAME: COUNT})
print(Config(), made, made.model_dump(), made.model_dump_json(), Config.model_json_schema())
for wrong in ({"speed": 5.0 * SPEED}, {"mode": "other"}, {"count": SPEED}, {"whole": 2.5}):
    try:
        Config(**wrong)
    except ValidationError as error:
        print(error)
